// What surroundings are prepared into, from one run to the next: preparing them takes two cores a tenth of a
// second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu/device.h"
#include "renderer/scene/digest.h"
#include "renderer/scene/environment.h"

namespace fire3dv::passes {

// Whoever keeps it. Called on any thread.
class EnvironmentStore {
 public:
  virtual ~EnvironmentStore() = default;
  // What was kept for this kind, unless it has another number of bytes.
  virtual std::optional<std::vector<std::byte>> find(const scene::Digest& kind, size_t bytes) = 0;
  virtual void keep(const scene::Digest& kind, std::span<const std::byte> maps) = 0;
};

// What maps are for: the picture, this device and driver, the shaders of this build that prepare it, and
// the recipe: all other numbers that they are made by.
scene::Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                               std::span<const uint32_t> recipe);

}  // namespace fire3dv::passes
