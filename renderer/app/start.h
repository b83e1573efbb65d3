// Start-up: steps shared by live and offline runs (device, environment, animations), and the main function of
// live runs.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/app/options/options.h"
#include "renderer/gpu/device/device.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/robot_pose.h"

namespace fire3dv::app {

// Opens the device of the options; report: receives its description.
Result<std::unique_ptr<gpu::Device>> open_device(gpu::Instance& instance, const Options& options,
                                                 gpu::DeviceReport* report = nullptr);

// Devices of --devices: the first one opened, and the indices of the secondary devices.
struct OpenDevices {
  std::unique_ptr<gpu::Device> first;
  std::vector<uint32_t> secondary;
};
// Opens the devices of the options.
Result<OpenDevices> open_devices(gpu::Instance& instance, const Options& options);

class SceneLoad;
// The robot of a loaded file, if it holds one. Reports a damaged one.
std::optional<state::RobotPose> find_robot(const SceneLoad& load);

// Null without the option.
Result<std::shared_ptr<const scene::EnvironmentImage>> load_environment(const std::filesystem::path& path);

// Warnings for settings without effect on the device: ray effects that it cannot trace, anisotropic
// filtering.
std::vector<std::string> settings_without_effect(const gpu::Device& device, const Options& options);

// Warns of instances that depth and labels lack, by name.
void warn_of_missing_labels(const scene::Scene& scene, const scene::SceneEdits& edits, float label_alpha);

// Note about the sun of the environment; empty: none is drawn as a light. After SceneRenderer::set_scene().
std::string describe_sun(const passes::SceneRenderer& renderer);

struct Playing {
  std::vector<uint32_t> chosen;
  std::optional<state::AnimationPlayer> player;
};

// Nothing without the option.
Result<std::optional<Playing>> open_animations(const Options& options, const scene::Scene& scene);

// Main function of the renderer after option parsing (run/run.cpp). Returns the exit code: 0, or after a
// printed error 1, or kNoGpuExitStatus.
int run(const Options& options);

}  // namespace fire3dv::app
