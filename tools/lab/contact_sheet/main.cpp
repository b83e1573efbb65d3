// Contact sheet program: fire3dv-contact-sheet FOLDER draws all glTF files of a folder, in the default look,
// on pages of thumbnails.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "base/command_line.h"
#include "base/text.h"
#include "renderer/camera/default_look.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/selection/device_choice.h"
#include "renderer/gpu/selection/required_gpu.h"
#include "renderer/scene/derived/key_light.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/settings/setting_table.h"
#include "renderer/sinks/frame.h"
#include "tools/lab/contact_sheet/asset_drawer.h"
#include "tools/lab/contact_sheet/pages.h"

namespace fire3dv::contact_sheet {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string folder, out = "contact-sheet", device, raster = "auto", shadows = "auto";
  PageLayout layout;
  bool require_gpu = false, validation = false;
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

// With the key light of the default look.
Result<scene::Scene> load(const fs::path& file, const settings::DrawSettings& settings) {
  Result<scene::Scene> scene = scene::load_gltf(file);
  if (scene && scene->textures.size() > settings.max_textures) {
    return Error{file.string() + " has " + std::to_string(scene->textures.size()) +
                 " textures, and room is made for " + std::to_string(settings.max_textures) +
                 ": split the file"};
  }
  if (scene && app::wants_key_light(app::KeyLight::automatic, false)) scene::add_key_light(*scene);
  return scene;
}

Result<void> draw_all(const std::vector<fs::path>& files, const Options& options, gpu::Device& device) {
  settings::DrawSettings settings = settings::default_settings();
  (void)settings::draw_setting("raster").set(options.raster, settings);
  (void)settings::draw_setting("shadows").set(options.shadows, settings);
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
      image = drawer.draw_by_default(*scene);
    } catch (const std::exception& failure) {  // fatal: a Vulkan error or out of memory
      return Error{file.string() + ": " + failure.what() + "; leave the file out"};
    }
    const DrawnCounts counts = drawer.counts();
    std::string note = std::to_string(counts.triangles) + " triangles";
    if (counts.lines > 0) note += ", " + std::to_string(counts.lines) + " lines";
    if (counts.points > 0) note += ", " + std::to_string(counts.points) + " points";
    if (Result<void> added = pages.add(name, image, note, scene->warnings); !added) return added;
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
  const Result<gpu::DeviceChoice> choice =
      gpu::choose_device(gpu::report_devices((*instance)->handle()), options.device, gpu::host_facts());
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
    const fire3dv::settings::DrawSetting& setting = fire3dv::settings::draw_setting(name);
    drawing.add(("--" + setting.name).c_str(), value, setting.value_name.c_str(), setting.help.c_str())
        ->check(fire3dv::one_of(setting.names));
  };
  add_setting("raster", options.raster);
  add_setting("shadows", options.shadows);
  drawing.add("--device", options.device, "DEVICE",
              "Vulkan device: index, name, cuda:N, uuid:HEX, pci:ADDRESS");
  drawing.add_flag("--require-gpu", options.require_gpu, "exit with status 3 rather than draw on the CPU");
  drawing.add_flag("--validation", options.validation, "Vulkan validation; a finding is an error");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (options.require_gpu) {
      if (const fire3dv::Result<void> found = fire3dv::gpu::check_required_gpu(options.device); !found) {
        std::fprintf(stderr, "fire3dv-contact-sheet: %s\n",
                     fire3dv::terminal_text(found.error().message).c_str());
        return fire3dv::gpu::kNoGpuExitStatus;
      }
    }
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
