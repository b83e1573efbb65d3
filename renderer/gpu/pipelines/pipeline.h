// Pipelines built from the embedded shaders: compute, graphics and ray tracing. Shaders reach their data by
// device address from push constants; descriptors serve textures, the acceleration structure and a frame's
// images.
#pragma once

#include <span>
#include <string_view>

#include "base/digest.h"
#include "renderer/gpu/device/device.h"
#include "renderer/gpu/device/resources.h"

namespace fire3dv::gpu {

constexpr uint32_t kPushConstantBytes = 128;  // guaranteed minimum of Vulkan

PipelineLayout create_pipeline_layout(Device& device, std::span<const VkDescriptorSetLayout> sets);

ShaderModule create_shader_module(Device& device, std::string_view name);

// True where the device is a CPU and shaders with CPU variants use them; see shaders/common/lanes.glsl.
bool uses_cpu_variants(const Device& device);

// Schedule of pipeline creation (see pipeline_builder.h).
// immediately: in order of request. next: before the queued pipelines; for slow pipelines that are certainly
// needed. on_first_use: on first use; for pipelines that few scenes need.
enum class Compile { immediately, next, on_first_use };
// shader: file name such as "post.comp"; the pipeline may still be compiling on return. constants:
// values of specialisation constants 0, 1, ...; the others keep the shader's defaults.
Pipeline create_compute_pipeline(Device& device, VkPipelineLayout layout, std::string_view shader,
                                 Compile make = Compile::immediately,
                                 std::span<const uint32_t> constants = {});

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
  bool dual_source = false;  // blending: the shader's second colour scales the background
  // Blending: the target's alpha, the share of scene-referred light, becomes less.
  bool is_display_referred = false;
  bool alpha_to_coverage = false;
  std::span<const uint32_t> fragment_constants;  // values of specialisation constants 0, 1, ...
};
// Cull mode, front face, viewport and scissor are dynamic.
Pipeline create_graphics_pipeline(Device& device, VkPipelineLayout layout, const GraphicsPipelineInfo& info);

// Ray-tracing pipeline with its shader binding table: one ray-generation, one miss and one any-hit shader,
// and a closest-hit shader where rays need one. The any-hit shader serves triangles that are not opaque.
class RayPipeline {
 public:
  RayPipeline() = default;
  RayPipeline(Device& device, VkPipelineLayout layout, std::string_view raygen, std::string_view miss,
              std::string_view any_hit, std::string_view closest_hit = {},
              std::span<const uint32_t> constants = {});

  // arguments: address of a VkTraceRaysIndirectCommandKHR. The caller binds descriptor sets and push
  // constants.
  void trace(VkCommandBuffer commands, VkDeviceAddress arguments) const;
  VkPipeline get() const { return pipeline_.get(); }
  explicit operator bool() const { return static_cast<bool>(pipeline_); }

 private:
  Device* device_ = nullptr;
  Pipeline pipeline_;
  Buffer table_;
  VkStridedDeviceAddressRegionKHR raygen_{}, miss_{}, hit_{};
};

// Cache key for device-dependent artefacts: device and driver identity, and a digest of the shaders.
// beginning: name prefix of the shaders to include; "" for all.
Digest device_kind(const VkPhysicalDeviceProperties& device, std::string_view beginning);

}  // namespace fire3dv::gpu
