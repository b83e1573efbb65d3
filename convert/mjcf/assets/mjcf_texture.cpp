#include "convert/mjcf/assets/mjcf_texture.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "convert/glb/write_glb.h"
#include "convert/mjcf/assets/mjcf_source.h"
#include "convert/mjcf/assets/png_pixels.h"
#include "convert/mjcf/assets/sky_image.h"
#include "convert/mjcf/assets/texture_pattern.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxPatternPixels = uint64_t{1} << 26;
constexpr size_t kMaxSkyBytes = size_t{3} << 24;  // of an image of a skybox
constexpr uint32_t kMaxFace = 512;                // of a generated skybox, in pixels
constexpr const char* kFaceFiles[] = {"fileright", "fileleft",  "fileup",
                                      "filedown",  "filefront", "fileback"};  // as of CubeFaces
constexpr const char* kFaceLetters = "RLUDFB";

std::optional<PngPixels> raw_pixels(
    std::span<const std::byte> bytes) {  // MuJoCo's format: width, height, RGB
  uint32_t size[2];
  if (bytes.size() < sizeof size) return std::nullopt;
  std::memcpy(size, bytes.data(), sizeof size);
  const uint64_t count = uint64_t{size[0]} * size[1];
  if (count == 0 || count > kMaxPatternPixels || bytes.size() != sizeof size + 3 * count) return std::nullopt;
  PngPixels pixels{size[0], size[1], std::vector<uint8_t>(3 * count)};
  std::memcpy(pixels.rgb.data(), bytes.data() + sizeof size, 3 * count);
  return pixels;
}

void flip(PngPixels& image, bool horizontally, bool vertically) {
  const size_t width = image.width, height = image.height;
  const auto swap_pixels = [&](size_t a, size_t b) {
    std::swap_ranges(image.rgb.begin() + static_cast<ptrdiff_t>(3 * a),
                     image.rgb.begin() + static_cast<ptrdiff_t>(3 * a + 3),
                     image.rgb.begin() + static_cast<ptrdiff_t>(3 * b));
  };
  for (size_t row = 0; row < height; ++row)
    for (size_t column = 0; column < width; ++column) {
      if (horizontally && column < width / 2)
        swap_pixels(row * width + column, row * width + width - 1 - column);
    }
  for (size_t row = 0; vertically && row < height / 2; ++row)
    for (size_t column = 0; column < width; ++column)
      swap_pixels(row * width + column, (height - 1 - row) * width + column);
}

class TextureReader {
 public:
  TextureReader(const MjcfSource& source, const MjcfElement& element)
      : source_(source), element_(element), from_(source.attributes(element, MjcfDefaults::kMain)) {}

  Result<MjcfTexture> read() {
    texture_.name = from_.name();
    texture_.is_cube = from_.text("type") != "2d";
    texture_.has_opacity = from_.integer("nchannel", 3) == 4;
    const TexturePattern pattern = read_pattern();
    const std::string name = from_.text("file");
    Result<void> done;
    if (texture_.is_cube)
      done = read_cube(pattern);
    else if (name.empty())
      done = draw(pattern);
    else
      done = read_image(name);
    if (!done) return done.error();
    return std::move(texture_);
  }

  Result<Image> read_sky() {
    CubeFaces faces;
    if (Result<void> done = read_faces(faces); !done) return done.error();
    // A gradient alone is the same all around.
    const TexturePattern pattern = read_pattern();
    const bool is_even = pattern.kind == "gradient" && pattern.mark != "random" && pattern.mark != "edge" &&
                         pattern.mark != "cross" && names_of_faces().empty();
    const PngPixels sky = sky_of(faces, is_even);
    Result<std::vector<std::byte>> png = png_of(sky.rgb, sky.width, sky.height, 3);
    if (!png) return png.error();
    const std::string name = from_.name();
    return Image{name.empty() ? "sky" : name, std::move(*png)};
  }

 private:
  // Names of the files of a cube: one for all faces, or up to six of single ones.
  std::vector<std::string> names_of_faces() const {
    std::vector<std::string> names;
    if (const std::string all = from_.text("file"); !all.empty()) return {all};
    bool has_any = false;
    for (const char* side : kFaceFiles) {
      names.push_back(from_.text(side));
      has_any = has_any || !names.back().empty();
    }
    return has_any ? names : std::vector<std::string>();
  }

  Result<PngPixels> read_pixels(const std::string& name) {
    const auto file = open(name);
    if (!file) return file.error();
    const std::span<const std::byte> bytes = file->second.view();
    std::optional<PngPixels> pixels = raw_pixels(bytes);
    if (!pixels) {
      Result<PngPixels> decoded = decode_png(bytes);
      if (!decoded) return Error{quote(file->first.string()) + ": " + decoded.error().message};
      pixels = std::move(*decoded);
    }
    return std::move(*pixels);
  }

  // Faces that no file gives stay empty, which are black in MuJoCo.
  Result<void> read_faces(CubeFaces& faces) {
    const std::vector<std::string> names = names_of_faces();
    const bool flips_x = from_.flag("hflip", false), flips_y = from_.flag("vflip", false);
    if (names.empty()) {
      TexturePattern pattern = read_pattern();
      if (pattern.width == 0) return Error{"it has no file and no width"};
      pattern.width = pattern.height = std::min(pattern.width, kMaxFace);
      for (size_t face = 0; face < faces.size(); ++face)
        faces[face] = {pattern.width, pattern.height, draw_face(pattern, face)};
      return {};
    }
    for (size_t i = 0; i < names.size(); ++i) {
      if (names[i].empty()) continue;
      Result<PngPixels> pixels = read_pixels(names[i]);
      if (!pixels) return pixels.error();
      if (pixels->rgb.size() > kMaxSkyBytes)
        return Error{quote(names[i]) + " has more than 16 million pixels"};
      if (names.size() == 1) {
        if (Result<void> cut = cut_grid(*pixels, faces); !cut) return cut;
      } else {
        faces[i] = std::move(*pixels);
      }
    }
    for (PngPixels& face : faces) flip(face, flips_x, flips_y);
    return {};
  }

  // gridsize="rows columns", gridlayout: a letter for each cell, '.' for none. Without a grid, all faces are
  // the whole image.
  Result<void> cut_grid(const PngPixels& image, CubeFaces& faces) const {
    const glm::dvec2 grid = from_.vec2("gridsize").value_or(glm::dvec2(1));
    const std::string layout = from_.text("gridlayout");
    if (grid == glm::dvec2(1)) {
      faces.fill(image);
      return {};
    }
    const auto rows = static_cast<uint32_t>(glm::clamp(grid.x, 1.0, 12.0)),
               columns = static_cast<uint32_t>(glm::clamp(grid.y, 1.0, 12.0));
    const uint32_t width = image.width / columns, height = image.height / rows;
    if (width == 0 || height == 0 || layout.size() < size_t{rows} * columns)
      return Error{"its gridsize and gridlayout do not fit its image"};
    for (uint32_t cell = 0; cell < rows * columns; ++cell) {
      const size_t face = std::string_view(kFaceLetters).find(layout[cell]);
      if (face == std::string_view::npos) continue;
      PngPixels cut{width, height, {}};
      for (uint32_t row = 0; row < height; ++row) {
        const size_t first =
            3 * ((size_t{cell / columns} * height + row) * image.width + size_t{cell % columns} * width);
        cut.rgb.insert(cut.rgb.end(), image.rgb.begin() + static_cast<ptrdiff_t>(first),
                       image.rgb.begin() + static_cast<ptrdiff_t>(first + size_t{3} * width));
      }
      faces[face] = std::move(cut);
    }
    return {};
  }

  TexturePattern read_pattern() const {
    TexturePattern pattern;
    pattern.kind = from_.text("builtin");
    pattern.mark = from_.text("mark");
    pattern.first = from_.vec3("rgb1").value_or(pattern.first);
    pattern.second = from_.vec3("rgb2").value_or(pattern.second);
    pattern.mark_color = from_.vec3("markrgb").value_or(pattern.mark_color);
    pattern.random = from_.number("random", pattern.random);
    pattern.width = static_cast<uint32_t>(std::max(0, from_.integer("width", 0)));
    pattern.height = static_cast<uint32_t>(std::max(0, from_.integer("height", 0)));
    return pattern;
  }

  Result<void> encode(const PngPixels& pixels) {
    Result<std::vector<std::byte>> png = png_of(pixels.rgb, pixels.width, pixels.height, 3);
    if (!png) return png.error();
    texture_.image = Image{from_.name(), std::move(*png)};
    return {};
  }

  Result<void> draw(const TexturePattern& pattern) {
    const uint64_t pixels = uint64_t{pattern.width} * pattern.height;
    if (pixels == 0 || pixels > kMaxPatternPixels)
      return Error{"it has no file, and its width times height is not from 1 to " +
                   std::to_string(kMaxPatternPixels)};
    return encode({pattern.width, pattern.height, draw_pattern(pattern)});
  }

  Result<std::pair<fs::path, FileBytes>> open(const std::string& name) {
    const Result<fs::path> file = source_.files().find(
        source_.file_name(name), source_.folders(element_, source_.compiler().texture_folder));
    if (!file) return file.error();
    Result<FileBytes> bytes = source_.files().read(*file);
    if (!bytes) return bytes.error();
    return std::pair(*file, std::move(*bytes));
  }

  Result<void> read_image(const std::string& name) {
    const auto file = open(name);
    if (!file) return file.error();
    const std::span<const std::byte> bytes = file->second.view();
    const bool flips_x = from_.flag("hflip", false), flips_y = from_.flag("vflip", false);
    if (std::optional<PngPixels> raw = raw_pixels(bytes)) {
      flip(*raw, flips_x, flips_y);
      return encode(*raw);
    }
    if ((flips_x || flips_y) && is_png_file(bytes)) {
      Result<PngPixels> pixels = decode_png(bytes);
      if (!pixels) return Error{quote(file->first.string()) + ": " + pixels.error().message};
      flip(*pixels, flips_x, flips_y);
      return encode(*pixels);
    }
    texture_.image = Image{sanitize_text(file->first.filename().string()), {bytes.begin(), bytes.end()}};
    return {};
  }

  // Mean over one file for all sides, or one for each.
  Result<void> read_cube(const TexturePattern& pattern) {
    std::vector<std::string> names = names_of_faces();
    std::erase(names, "");
    if (names.empty()) {
      texture_.mean_color = mean_of_cube(pattern);
      return {};
    }
    glm::dvec3 sum(0);
    for (const std::string& side : names) {
      const Result<PngPixels> pixels = read_pixels(side);
      if (!pixels) return pixels.error();
      sum += mean_of(*pixels);
    }
    texture_.mean_color = glm::vec3(sum / static_cast<double>(names.size()));
    return {};
  }

  static glm::dvec3 mean_of(const PngPixels& pixels) {  // linear
    std::array<float, 256> linear;
    for (size_t i = 0; i < linear.size(); ++i)
      linear[i] = linear_from_srgb(glm::vec3(static_cast<float>(i) / 255)).r;
    glm::dvec3 sum(0);
    for (size_t i = 0; i < pixels.rgb.size(); ++i)
      sum[static_cast<int>(i % 3)] += static_cast<double>(linear[pixels.rgb[i]]);
    return sum / std::max(1.0, static_cast<double>(pixels.rgb.size() / 3));
  }

  const MjcfSource& source_;
  const MjcfElement& element_;
  const MjcfAttributes from_;
  MjcfTexture texture_;
};

}  // namespace

Result<MjcfTexture> read_mjcf_texture(const MjcfSource& source, const MjcfElement& element) {
  return TextureReader(source, element).read();
}

Result<Image> read_mjcf_sky(const MjcfSource& source, const MjcfElement& element) {
  return TextureReader(source, element).read_sky();
}

}  // namespace fire3dv::convert
