// Cache of prepared environment maps across runs. Reason: preparation takes two cores a tenth of a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "protocol/base/digest.h"
#include "renderer/gpu/device/device.h"
#include "renderer/scene/textures/environment.h"

namespace fire3dv::passes {

// Interface of the cache. Called on any thread.
class EnvironmentStore {
 public:
  virtual ~EnvironmentStore() = default;
  // Returns the cached maps of this kind, or nothing if the size differs.
  virtual std::optional<std::vector<std::byte>> find(const Digest& kind, size_t bytes) = 0;
  virtual void keep(const Digest& kind, std::span<const std::byte> maps) = 0;
};

// Cache key of environment maps: image, device, driver, shaders and the recipe with all other parameters.
Digest environment_kind(const VkPhysicalDeviceProperties& device, const scene::EnvironmentImage& image,
                        std::span<const uint32_t> recipe);

}  // namespace fire3dv::passes
