// Cache key for device-dependent artefacts: device and driver identity, and a digest of the shaders.
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "protocol/base/digest.h"

namespace fire3dv::passes {

// beginning: name prefix of the shaders to include; "" for all.
Digest device_kind(const VkPhysicalDeviceProperties& device, std::string_view beginning);

}  // namespace fire3dv::passes
