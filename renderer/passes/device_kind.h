// What something that a device made is of no use without: the same device and driver, and the same shaders.
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "renderer/scene/digest.h"

namespace fire3dv::passes {

// beginning: of the names of this build's shaders that count; "" for all.
scene::Digest device_kind(const VkPhysicalDeviceProperties& device, std::string_view beginning);

}  // namespace fire3dv::passes
