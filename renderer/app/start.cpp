#include "renderer/app/start.h"

#include <algorithm>
#include <cstdio>

#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "protocol/robot/robot_file.h"
#include "renderer/loading/scene_load.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::app {

void say(const std::string& text) {
  print_log_line("fire3dv", text);
}

int fail(const Error& error) {
  say(error_line(error.message));
  return 1;
}

void log_cache_error(const Error& error) {
  say(warning("cache: " + error.message +
              "; the next start will be as slow as this one (--cache names another folder)"));
}

Result<std::unique_ptr<gpu::Device>> open_device(gpu::Instance& instance, const Options& options,
                                                 gpu::DeviceReport* report) {
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  Result<gpu::DeviceChoice> choice =
      gpu::choose_device(reports, options.device, gpu::graphics_vendors_present());
  if (!choice) return choice.error();
  for (const std::string& note : choice->notes) say(warning("device: " + note));
  say("device " + gpu::describe(reports[choice->index]));
  if (report) *report = reports[choice->index];
  return gpu::Device::create(instance, choice->index, !options.headless, options.async_compute);
}

Result<OpenDevices> open_devices(gpu::Instance& instance, const Options& options) {
  OpenDevices open;
  if (options.devices.empty()) {
    Result<std::unique_ptr<gpu::Device>> device = open_device(instance, options);
    if (!device) return device.error();
    open.first = std::move(*device);
    return open;
  }
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  Result<std::vector<gpu::DeviceChoice>> choices =
      gpu::choose_devices(reports, options.devices, gpu::graphics_vendors_present());
  if (!choices) return choices.error();
  for (const gpu::DeviceChoice& choice : *choices) {
    for (const std::string& note : choice.notes) say(warning("device: " + note));
    say("device " + gpu::describe(reports[choice.index]));
    if (reports[choice.index].name != reports[choices->front().index].name)
      say("device: images by " + reports[choice.index].name + " and " + reports[choices->front().index].name +
          " may differ a little, as those of other devices do");
    if (&choice != &choices->front()) open.further.push_back(choice.index);
  }
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(instance, choices->front().index, !options.headless, options.async_compute);
  if (!device) return device.error();
  open.first = std::move(*device);
  return open;
}

void describe(const std::filesystem::path& path, const scene::Scene& scene) {
  constexpr size_t kWarningsShown = 20;
  for (size_t i = 0; i < std::min(scene.warnings.size(), kWarningsShown); ++i)
    say(warning(scene.warnings[i]));
  if (scene.warnings.size() > kWarningsShown) {
    say(warning("and " + std::to_string(scene.warnings.size() - kWarningsShown) + " more"));
  }
  size_t triangles = 0;
  for (const scene::Primitive& primitive : scene.primitives) triangles += primitive.index_count / 3;
  const bool has_key_light = !scene.lights.empty() && scene.lights.front().is_default;
  const size_t added = has_key_light ? 1 : 0;
  say(path.string() + ": " + counted(scene.nodes.size() - added, "node") + ", " +
      counted(triangles, "triangle") + ", " + counted(scene.lights.size() - added, "light") +
      (has_key_light ? " (a key light is added), " : ", ") + counted(scene.cameras.size(), "camera") + ", " +
      counted(scene.textures.size(), "texture"));
}

Result<void> can_show(const gpu::Device& device, const scene::Scene& scene) {
  const uint32_t most = gpu::BindlessTextures::most(device);
  if (scene.textures.size() <= most) return {};
  return Error{scene.source.string() + " has " + std::to_string(scene.textures.size()) + " textures, but " +
               device.report().name + " takes " + std::to_string(most) +
               " at most: split the file, or choose another device with --device"};
}

Result<void> make_room(gpu::Device& device, passes::DrawSettings settings, const scene::Scene& scene,
                       std::optional<passes::SceneRenderer>& renderer) {
  if (scene.textures.size() <= settings.max_textures) return {};
  if (Result<void> can = can_show(device, scene); !can) return can;
  settings.max_textures = static_cast<uint32_t>(scene.textures.size());
  renderer.reset();
  renderer.emplace(device, settings);
  return {};
}

std::optional<state::RobotPose> find_robot(const SceneLoad& load) {
  Result<std::optional<robot::Robot>> found = robot::find_robot(load.gltf_file(), true);
  if (!found) {
    say(warning(found.error().message + "; its joints cannot be moved"));
    return std::nullopt;
  }
  if (!*found) return std::nullopt;
  return state::RobotPose(std::move(**found));
}

Result<std::shared_ptr<const scene::EnvironmentImage>> load_environment(const std::filesystem::path& path) {
  if (path.empty()) return std::shared_ptr<const scene::EnvironmentImage>();
  Result<scene::EnvironmentImage> image = scene::load_environment(path);
  if (!image) return Error{"--environment: " + image.error().message};
  return std::shared_ptr<const scene::EnvironmentImage>(
      std::make_shared<scene::EnvironmentImage>(std::move(*image)));
}

Result<std::optional<Playing>> open_animations(const Options& options, const scene::Scene& scene) {
  if (options.animate.empty()) return std::optional<Playing>();
  Result<std::vector<uint32_t>> chosen = state::choose_animations(scene, options.animate);
  if (!chosen) return chosen.error();
  std::string playing = "playing animation";
  constexpr size_t kNamesShown = 10;
  for (size_t i = 0; i < std::min(chosen->size(), kNamesShown); ++i) {
    playing += (i ? ", " : " ") + state::animation_title(scene, (*chosen)[i]);
  }
  if (chosen->size() > kNamesShown)
    playing += " and " + std::to_string(chosen->size() - kNamesShown) + " more";
  say(playing + ", of " + std::to_string(scene.animations.size()));
  Playing playing_now{*chosen, {}};
  playing_now.player.emplace(scene, *chosen);
  return std::optional<Playing>(std::move(playing_now));
}

}  // namespace fire3dv::app
