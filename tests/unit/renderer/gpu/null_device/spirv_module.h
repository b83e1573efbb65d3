// Interface of a shader module, read from its SPIR-V: capabilities, descriptors, specialisation constants,
// and the limits of a device that it needs.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "renderer/gpu/device/vk.h"

namespace fire3dv::test {

struct SpirvModule {
  VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
  std::set<uint32_t> capabilities;                                        // spv::Capability
  std::map<std::pair<uint32_t, uint32_t>, VkDescriptorType> descriptors;  // by set and binding
  std::map<uint32_t, bool> booleans;                                      // specialisation constants
  uint32_t shared_bytes = 0, push_constant_bytes = 0, threads = 0;        // threads of a workgroup
};

SpirvModule read_spirv(std::span<const uint32_t> code);

}  // namespace fire3dv::test
