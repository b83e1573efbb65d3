// Contact sheet program: fire3dv-contact-sheet FOLDER draws all glTF files of a folder on pages of
// thumbnails.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/command_line.h"
#include "base/files.h"
#include "base/text.h"
#include "renderer/gpu/device/device.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/settings/setting_table.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/output_text.h"
#include "renderer/sinks/png.h"
#include "tools/lab/contact_sheet/asset_drawer.h"

namespace fire3dv::contact_sheet {
namespace {

// Writer of contact sheets: PNG pages of thumbnails with names in 3x5 pixel letters, and a text index.
struct PageLayout {
  uint32_t columns = 8, rows = 6;
  uint32_t width = 160, height = 120;  // of a thumbnail, pixels
};

class Pages {
 public:
  // The folder must exist.
  Pages(std::filesystem::path folder, const PageLayout& layout)
      : folder_(std::move(folder)), layout_(layout) {}

  // image: must have the size of thumbnails. note: additional text for the index.
  Result<void> add(const std::string& name, const sinks::FrameImage& image, const std::string& note);
  void add_refused(const std::string& name, const std::string& reason);
  Result<void> finish();  // writes the last page and index.txt
  uint32_t page_count() const { return pages_; }

 private:
  void begin_page();
  Result<void> end_page();

  std::filesystem::path folder_;
  PageLayout layout_;
  sinks::FrameImage page_;
  uint32_t on_page_ = 0, pages_ = 0;
  std::string index_, refused_;
};

constexpr uint32_t kDot = 2;                 // pixels
constexpr uint32_t kLetterWidth = 4 * kDot;  // includes the gap
constexpr uint32_t kLineHeight = 7 * kDot;

// Draws from the top left corner, clipped to the image. Lower case is drawn as upper case, unknown characters
// as question marks.
void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color);

constexpr uint32_t kGap = 6;
constexpr uint32_t kLabelLines = 2;
constexpr uint32_t kLabelHeight = kLabelLines * kLineHeight + kDot;
constexpr uint8_t kPaper = 24;
constexpr std::array<uint8_t, 3> kInk{225, 225, 225};

std::string page_name(uint32_t number) {
  char name[32];
  std::snprintf(name, sizeof name, "page_%03u.png", number);
  return name;
}

// Sanitises untrusted names to one line of the index.
std::string one_line(const std::string& text) {
  constexpr size_t kLongest = 1000;
  return sinks::printable_utf8(text, kLongest);
}

// Bitmap letter: five rows from the top; each digit holds three pixels, the left one worth 4.
struct Letter {
  char character;
  std::string_view rows;
};
constexpr Letter kLetters[] = {
    {'A', "25755"}, {'B', "65656"}, {'C', "34443"}, {'D', "65556"}, {'E', "74647"}, {'F', "74644"},
    {'G', "34553"}, {'H', "55755"}, {'I', "72227"}, {'J', "11152"}, {'K', "55655"}, {'L', "44447"},
    {'M', "57755"}, {'N', "65555"}, {'O', "25552"}, {'P', "65644"}, {'Q', "25573"}, {'R', "65655"},
    {'S', "34216"}, {'T', "72222"}, {'U', "55557"}, {'V', "55552"}, {'W', "55775"}, {'X', "55255"},
    {'Y', "55222"}, {'Z', "71247"}, {'0', "75557"}, {'1', "26227"}, {'2', "61247"}, {'3', "61216"},
    {'4', "55711"}, {'5', "74616"}, {'6', "34652"}, {'7', "71122"}, {'8', "25252"}, {'9', "25316"},
    {'.', "00002"}, {'_', "00007"}, {'-', "00700"}, {'/', "11244"}, {'+', "02720"}, {'(', "12221"},
    {')', "42224"}, {',', "00024"}, {':', "02020"}, {' ', "00000"}, {'?', "61202"}};

std::string_view rows_of(char character) {
  if (character >= 'a' && character <= 'z') character = static_cast<char>(character - 'a' + 'A');
  const auto* found = std::find_if(std::begin(kLetters), std::end(kLetters),
                                   [&](const Letter& letter) { return letter.character == character; });
  return found == std::end(kLetters) ? kLetters[std::size(kLetters) - 1].rows : found->rows;
}

void Pages::begin_page() {
  page_.width = kGap + layout_.columns * (layout_.width + kGap);
  page_.height = kGap + layout_.rows * (layout_.height + kLabelHeight + kGap);
  page_.rgba8.assign(size_t{4} * page_.width * page_.height, kPaper);
  for (size_t alpha = 3; alpha < page_.rgba8.size(); alpha += 4) page_.rgba8[alpha] = 255;
  on_page_ = 0;
  ++pages_;
}

Result<void> Pages::end_page() {
  on_page_ = 0;
  return sinks::write_png(folder_ / page_name(pages_), page_);
}

Result<void> Pages::add(const std::string& name, const sinks::FrameImage& image, const std::string& note) {
  FIRE3DV_ASSERT(image.width == layout_.width && image.height == layout_.height);
  if (on_page_ == 0) begin_page();
  const uint32_t column = on_page_ % layout_.columns, row = on_page_ / layout_.columns;
  const uint32_t left = kGap + column * (layout_.width + kGap);
  const uint32_t top = kGap + row * (layout_.height + kLabelHeight + kGap);
  for (uint32_t y = 0; y < image.height; ++y) {
    std::copy_n(image.rgba8.begin() + size_t{4} * y * image.width, size_t{4} * image.width,
                page_.rgba8.begin() + 4 * (size_t{top + y} * page_.width + left));
  }
  // The end of a name distinguishes files better than its start.
  const size_t letters = std::max(layout_.width / kLetterWidth, 1u);
  const std::string label =
      name.size() > kLabelLines * letters ? name.substr(name.size() - kLabelLines * letters) : name;
  for (uint32_t line = 0; line < kLabelLines && line * letters < label.size(); ++line) {
    write_text(page_, left, top + layout_.height + kDot + line * kLineHeight,
               label.substr(line * letters, letters), kInk);
  }
  index_ += page_name(pages_) + " row " + std::to_string(row + 1) + " column " + std::to_string(column + 1) +
            ": " + one_line(name) + ": " + one_line(note) + '\n';
  if (++on_page_ < layout_.columns * layout_.rows) return {};
  return end_page();
}

void Pages::add_refused(const std::string& name, const std::string& reason) {
  refused_ += "refused: " + one_line(name) + ": " + one_line(reason) + '\n';
}

Result<void> Pages::finish() {
  if (on_page_ > 0) {
    if (Result<void> written = end_page(); !written) return written;
  }
  const std::string text = index_ + refused_;
  return fire3dv::write_whole_file(folder_ / "index.txt",
                                   {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

void write_text(sinks::FrameImage& image, uint32_t x, uint32_t y, std::string_view text,
                std::array<uint8_t, 3> color) {
  for (const char character : text) {
    const std::string_view rows = rows_of(character);
    for (uint32_t i = 0; i < 5 * kDot * 3 * kDot; ++i) {
      const uint32_t dx = i % (3 * kDot), dy = i / (3 * kDot);
      if (!((rows[dy / kDot] - '0') >> (2 - dx / kDot) & 1)) continue;
      if (x + dx >= image.width || y + dy >= image.height) continue;
      std::copy(color.begin(), color.end(),
                image.rgba8.begin() + 4 * (size_t{y + dy} * image.width + x + dx));
    }
    x += kLetterWidth;
  }
}

namespace fs = std::filesystem;

struct Options {
  std::string folder, out = "contact-sheet", device, raster = "auto", shadows = "auto";
  PageLayout layout;
  bool validation = false;
};

// Symbolic links are not followed, so that only the named folder is read.
Result<std::vector<fs::path>> find_assets(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::string extension = entry->path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::error_code unreadable;
    if ((extension == ".gltf" || extension == ".glb") && entry->is_regular_file(unreadable))
      found.push_back(entry->path());
  }
  if (error) return Error{folder.string() + ": " + error.message() + "; name a folder that can be read"};
  if (found.empty()) return Error{folder.string() + " holds no .gltf or .glb files"};
  std::sort(found.begin(), found.end());
  return found;
}

Result<scene::Scene> load(const fs::path& file, const passes::DrawSettings& settings) {
  Result<scene::Scene> scene = scene::load_gltf(file);
  if (scene && scene->textures.size() > settings.max_textures) {
    return Error{file.string() + " has " + std::to_string(scene->textures.size()) +
                 " textures, and room is made for " + std::to_string(settings.max_textures) +
                 ": split the file"};
  }
  return scene;
}

Result<void> draw_all(const std::vector<fs::path>& files, const Options& options, gpu::Device& device) {
  passes::DrawSettings settings;
  (void)passes::draw_setting("raster").set(options.raster, settings);
  (void)passes::draw_setting("shadows").set(options.shadows, settings);
  AssetDrawer drawer(device, {options.layout.width, options.layout.height}, settings);
  Pages pages(options.out, options.layout);
  size_t refused = 0;
  for (const fs::path& file : files) {
    const std::string name = file.lexically_relative(options.folder).generic_string();
    const Result<scene::Scene> scene = load(file, settings);
    if (!scene) {
      std::printf("refused: %s\n", fire3dv::terminal_text(scene.error().message).c_str());
      pages.add_refused(name, scene.error().message);
      ++refused;
      continue;
    }
    sinks::FrameImage image;
    try {
      image = drawer.draw_framed(*scene);
    } catch (const std::exception& failure) {  // fatal: a Vulkan error or out of memory
      return Error{file.string() + ": " + failure.what() + "; leave the file out"};
    }
    const DrawnCounts counts = drawer.counts();
    std::string note = std::to_string(counts.triangles) + " triangles";
    if (counts.lines > 0) note += ", " + std::to_string(counts.lines) + " lines";
    if (counts.points > 0) note += ", " + std::to_string(counts.points) + " points";
    if (!scene->warnings.empty()) note += ", " + std::to_string(scene->warnings.size()) + " warnings";
    if (Result<void> added = pages.add(name, image, note); !added) return added;
  }
  if (Result<void> finished = pages.finish(); !finished) return finished;
  std::printf("%zu drawn, %zu refused; %u pages and index.txt in %s\n", files.size() - refused, refused,
              pages.page_count(), options.out.c_str());
  return {};
}

Result<void> run(const Options& options) {
  const Result<std::vector<fs::path>> files = find_assets(options.folder);
  if (!files) return files.error();
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) return Error{"--out " + options.out + ": " + error.message()};
  gpu::InstanceOptions instance_options;
  instance_options.validation = options.validation;
  Result<std::unique_ptr<gpu::Instance>> instance = gpu::Instance::create(instance_options);
  if (!instance) return instance.error();
  const Result<gpu::DeviceChoice> choice = gpu::choose_device(
      gpu::report_devices((*instance)->handle()), options.device, gpu::graphics_vendors_present());
  if (!choice) return choice.error();
  {
    Result<std::unique_ptr<gpu::Device>> device = gpu::Device::create(**instance, choice->index, false);
    if (!device) return device.error();
    if (Result<void> drawn = draw_all(*files, options, **device); !drawn) return drawn;
  }
  if (const uint64_t messages = (*instance)->validation_messages())
    return Error{std::to_string(messages) + " validation messages"};
  return {};
}

}  // namespace
}  // namespace fire3dv::contact_sheet

int main(int argc, char** argv) {
  using namespace fire3dv::contact_sheet;
  CLI::App app{"Draws every glTF file of a folder and its subfolders on pages of thumbnails.",
               "fire3dv-contact-sheet"};
  fire3dv::set_help(app, "FOLDER [OPTIONS]");
  fire3dv::set_program_flags(app);
  app.footer("Details: man fire3dv-contact-sheet.");
  Options options;
  app.add_option("folder", options.folder, "folder of .gltf and .glb files")->required();
  fire3dv::OptionGroup images(app, "Images"), drawing(app, "Drawing");
  images.add("--out", options.out, "DIR", "folder of the pages and index.txt");
  const auto add_number = [&](const char* name, uint32_t& value, const char* text, uint32_t least,
                              uint32_t most) {
    images.add(name, value, "N", text)->check(fire3dv::in_range(least, most));
  };
  add_number("--columns", options.layout.columns, "thumbnails per row, 1 to 32", 1, 32);
  add_number("--rows", options.layout.rows, "rows per page, 1 to 32", 1, 32);
  add_number("--width", options.layout.width, "width of a thumbnail in pixels, 16 to 512", 16, 512);
  add_number("--height", options.layout.height, "height of a thumbnail in pixels, 16 to 512", 16, 512);
  const auto add_setting = [&](const char* name, std::string& value) {
    const fire3dv::passes::DrawSetting& setting = fire3dv::passes::draw_setting(name);
    drawing.add(("--" + setting.name).c_str(), value, setting.value_name.c_str(), setting.help.c_str())
        ->check(fire3dv::one_of(setting.names));
  };
  add_setting("raster", options.raster);
  add_setting("shadows", options.shadows);
  drawing.add("--device", options.device, "INDEX|NAME", "Vulkan device");
  drawing.add_flag("--validation", options.validation, "Vulkan validation; a finding is an error");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (const fire3dv::Result<void> done = run(options); !done) {
      std::fprintf(stderr, "fire3dv-contact-sheet: %s\n",
                   fire3dv::terminal_text(done.error().message).c_str());
      return 1;
    }
  } catch (const std::exception& failure) {  // Vulkan error before any file is drawn
    std::fprintf(stderr, "fire3dv-contact-sheet: %s\n", failure.what());
    return 1;
  }
  return 0;
}
