#include "renderer/app/start.h"

#include <algorithm>
#include <cstdio>

#include "base/log.h"
#include "base/plural.h"
#include "base/process/failure.h"
#include "base/text.h"
#include "protocol/robot/robot_file.h"
#include "renderer/gpu/selection/device_choice.h"
#include "renderer/loading/scene_load.h"
#include "renderer/passes/outputs/silhouettes.h"
#include "renderer/passes/ray_effects/ray_effects_pass.h"
#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/textures/environment.h"
#include "renderer/scene/textures/environment_sun.h"

namespace fire3dv::app {

Result<std::unique_ptr<gpu::Device>> open_device(gpu::Instance& instance, const Options& options,
                                                 gpu::DeviceReport* report) {
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  Result<gpu::DeviceChoice> choice = gpu::choose_device(reports, options.device, gpu::host_facts());
  if (!choice) return choice.error();
  for (const std::string& note : choice->notes) log_message(warning("device: " + note));
  log_message("device " + gpu::describe(reports[choice->index]));
  if (report) *report = reports[choice->index];
  return gpu::Device::create(instance, choice->index, !options.headless, options.async_compute);
}

Result<OpenDevices> open_devices(gpu::Instance& instance, const Options& options) {
  const Activity activity("opening the Vulkan device");
  OpenDevices open;
  if (options.devices.empty()) {
    Result<std::unique_ptr<gpu::Device>> device = open_device(instance, options);
    if (!device) return device.error();
    open.first = std::move(*device);
    return open;
  }
  const std::vector<gpu::DeviceReport> reports = gpu::report_devices(instance.handle());
  Result<std::vector<gpu::DeviceChoice>> choices =
      gpu::choose_devices(reports, options.devices, gpu::host_facts());
  if (!choices) return choices.error();
  for (const gpu::DeviceChoice& choice : *choices) {
    for (const std::string& note : choice.notes) log_message(warning("device: " + note));
    log_message("device " + gpu::describe(reports[choice.index]));
    if (reports[choice.index].name != reports[choices->front().index].name)
      log_message("device: images by " + reports[choice.index].name + " and " +
                  reports[choices->front().index].name +
                  " may differ a little, as those of other devices do");
    if (&choice != &choices->front()) open.secondary.push_back(choice.index);
  }
  Result<std::unique_ptr<gpu::Device>> device =
      gpu::Device::create(instance, choices->front().index, !options.headless, options.async_compute);
  if (!device) return device.error();
  open.first = std::move(*device);
  return open;
}

std::optional<state::RobotPose> find_robot(const SceneLoad& load) {
  Result<std::optional<robot::Robot>> found = robot::find_robot(load.gltf_file(), true);
  if (!found) {
    log_message(warning(found.error().message + "; its joints cannot be moved"));
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

std::vector<std::string> settings_without_effect(const gpu::Device& device, const Options& options) {
  std::vector<std::string> warnings;
  if (options.draw.anisotropy > 1 && !device.report().anisotropy)
    warnings.push_back("--anisotropy: " + device.report().name +
                       " filters isotropically: images are those of --anisotropy 1");
  if (!options.draw.ray_effects.on.any()) return warnings;
  const bool has_visibility_buffer =
      options.draw.raster != settings::RasterPath::forward && device.report().int64_atomics;
  const Result<void> can = passes::can_trace_ray_effects(device, has_visibility_buffer);
  if (!can) warnings.push_back("--ray-effects: " + can.error().message);
  return warnings;
}

void warn_of_missing_labels(const scene::Scene& scene, const scene::SceneEdits& edits, float label_alpha) {
  const std::vector<uint32_t> nodes = passes::nodes_without_labels(scene, &edits, label_alpha);
  if (nodes.empty()) return;
  constexpr size_t kNamesShown = 5;
  std::string names;
  for (size_t i = 0; i < std::min(nodes.size(), kNamesShown); ++i)
    names += (i ? ", " : "") + quote(scene.nodes[nodes[i]].name);
  if (nodes.size() > kNamesShown) names += " ...";
  char limit[32];
  std::snprintf(limit, sizeof limit, "%g", static_cast<double>(label_alpha));
  log_message(warning(counted(nodes.size(), "blended instance") +
                      " will have no depth and no labels, with alpha not above " + limit +
                      " (--label-alpha): " + names));
}

std::string describe_sun(const passes::SceneRenderer& renderer) {
  const std::optional<scene::EnvironmentSun>& sun = renderer.gpu_scene().sun;
  if (!sun || renderer.traces_paths()) return "";
  return "the environment's sun (" + scene::describe(*sun) +
         ") is a light with shadows; --environment-sun off keeps it in the image";
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
  log_message(playing + ", of " + std::to_string(scene.animations.size()));
  Playing playing_now{*chosen, {}};
  playing_now.player.emplace(scene, *chosen);
  return std::optional<Playing>(std::move(playing_now));
}

}  // namespace fire3dv::app
