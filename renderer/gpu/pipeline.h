// Pipelines from the embedded shaders. Shaders reach their data by device address from push constants;
// descriptors are left for textures, the acceleration structure and a frame's images.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "renderer/gpu/device.h"

namespace fire3dv::gpu {

constexpr uint32_t kPushConstantBytes = 128;  // what every device has

PipelineLayout create_pipeline_layout(Device& device, std::span<const VkDescriptorSetLayout> sets);

ShaderModule create_shader_module(Device& device, std::string_view name);

// Whether shaders are taken in their variants for a device that is a CPU, where there are such; see
// shaders/common/lanes.glsl.
bool takes_cpu_variants(const Device& device);

// name: the shader's file name, as in "post.comp".
// It may still be on its way: see pipeline_making.h. One that few scenes need is made when it is first used;
// one that takes long and is needed for certain is made before those that wait already.
enum class Make { at_once, next, when_used };
// constants: of the shader's specialisation constants 0, 1, ...; those of others are left as the shader has
// them.
Pipeline create_compute_pipeline(Device& device, VkPipelineLayout layout, std::string_view shader,
                                 Make make = Make::at_once, std::span<const uint32_t> constants = {});

struct GraphicsPipelineInfo {
  std::string_view vertex_shader;
  std::string_view fragment_shader;  // empty: depth only
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkFormat color_format = VK_FORMAT_UNDEFINED;
  VkFormat depth_format = VK_FORMAT_D32_SFLOAT;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  bool depth_write = true;  // depth is reversed: greater is nearer
  VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  bool blend = false;        // premultiplied alpha over
  bool dual_source = false;  // blending: what lies behind is scaled by the shader's second colour
  bool alpha_to_coverage = false;
};
// Cull mode, front face, viewport and scissor are dynamic.
Pipeline create_graphics_pipeline(Device& device, VkPipelineLayout layout, const GraphicsPipelineInfo& info);

}  // namespace fire3dv::gpu
