// The steps of a program's start that a live run and an offline one share: device, surroundings, animations,
// and what is said of them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/app/options.h"
#include "renderer/gpu/device.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/state/animation.h"

namespace fire3dv::app {

void say(const std::string& text);  // to the user, on standard error
int fail(const Error& error);       // the same, and the exit code
// A run without a cache is a good run.
void say_of_cache(const Error& error);

// The one that the options want; report: what it says of itself.
Result<std::unique_ptr<gpu::Device>> open_device(gpu::Instance& instance, const Options& options,
                                                 gpu::DeviceReport* report = nullptr);

// Of the devices that --devices names the first, and after it the indices of the others.
struct OpenDevices {
  std::unique_ptr<gpu::Device> first;
  std::vector<uint32_t> further;
};
// All that the options want.
Result<OpenDevices> open_devices(gpu::Instance& instance, const Options& options);

// Warnings, and what is in the scene.
void describe(const std::filesystem::path& path, const scene::Scene& scene);

// What can be known before its scene takes the place of another.
Result<void> can_show(const gpu::Device& device, const scene::Scene& scene);

// Few scenes have so many textures that the renderer has to be made anew for them.
Result<void> make_room(gpu::Device& device, passes::DrawSettings settings, const scene::Scene& scene,
                       std::optional<passes::SceneRenderer>& renderer);

// Null without the option.
Result<std::shared_ptr<const scene::EnvironmentImage>> load_surroundings(const std::filesystem::path& path);

struct Playing {
  std::vector<uint32_t> chosen;
  std::optional<state::AnimationPlayer> player;
};

// Nothing without the option.
Result<std::optional<Playing>> open_animations(const Options& options, const scene::Scene& scene);

}  // namespace fire3dv::app
