#include "renderer/gpu/pipelines/ray_pipeline.h"

#include <array>
#include <cstring>
#include <mutex>
#include <vector>

namespace fire3dv::gpu {
namespace {

VkDeviceSize align_up(VkDeviceSize value, VkDeviceSize alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

// Drivers that emulate ray tracing in compute share undocumented state between devices, so creation is
// serialised.
std::mutex& making() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

RayPipeline::RayPipeline(Device& device, VkPipelineLayout layout, std::string_view raygen,
                         std::string_view miss, std::string_view any_hit)
    : device_(&device) {
  const std::array modules{create_shader_module(device, raygen), create_shader_module(device, miss),
                           create_shader_module(device, any_hit)};
  constexpr VkShaderStageFlagBits kStages[] = {VK_SHADER_STAGE_RAYGEN_BIT_KHR, VK_SHADER_STAGE_MISS_BIT_KHR,
                                               VK_SHADER_STAGE_ANY_HIT_BIT_KHR};
  std::array<VkPipelineShaderStageCreateInfo, 3> stages{};
  std::array<VkRayTracingShaderGroupCreateInfoKHR, 3> groups{};
  for (uint32_t i = 0; i < 3; ++i) {
    stages[i] = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    stages[i].stage = kStages[i];
    stages[i].module = modules[i].get();
    stages[i].pName = "main";
    groups[i] = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
    groups[i].type = i == 2 ? VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR
                            : VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR;
    groups[i].generalShader = i == 2 ? VK_SHADER_UNUSED_KHR : i;
    groups[i].anyHitShader = i == 2 ? i : VK_SHADER_UNUSED_KHR;
    groups[i].closestHitShader = groups[i].intersectionShader = VK_SHADER_UNUSED_KHR;
  }
  VkRayTracingPipelineCreateInfoKHR info{VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
  info.stageCount = stages.size();
  info.pStages = stages.data();
  info.groupCount = groups.size();
  info.pGroups = groups.data();
  info.maxPipelineRayRecursionDepth = 1;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  {
    const std::scoped_lock one_device(making());
    FIRE3DV_VK(device.functions().create_ray_tracing_pipelines(
        device.handle(), VK_NULL_HANDLE, device.pipeline_cache(), 1, &info, nullptr, &pipeline));
  }
  pipeline_ = Pipeline(device, pipeline);

  const auto& limits = device.ray_pipeline_limits();
  const VkDeviceSize stride =
      align_up(align_up(limits.shaderGroupHandleSize, limits.shaderGroupHandleAlignment),
               limits.shaderGroupBaseAlignment);
  std::vector<std::byte> handles(size_t{3} * limits.shaderGroupHandleSize);
  FIRE3DV_VK(device.functions().get_shader_group_handles(device.handle(), pipeline, 0, 3, handles.size(),
                                                         handles.data()));
  table_ = create_buffer(device, 4 * stride, VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR, Memory::upload);
  const VkDeviceAddress first = align_up(table_.address, limits.shaderGroupBaseAlignment);
  for (uint32_t i = 0; i < 3; ++i) {
    std::memcpy(table_.mapped + (first - table_.address) + i * stride,
                handles.data() + size_t{i} * limits.shaderGroupHandleSize, limits.shaderGroupHandleSize);
  }
  raygen_ = {first, stride, stride};
  miss_ = {first + stride, stride, stride};
  hit_ = {first + 2 * stride, stride, stride};
}

void RayPipeline::trace(VkCommandBuffer commands, VkDeviceAddress arguments) const {
  const VkStridedDeviceAddressRegionKHR callable{};
  device_->functions().cmd_trace_rays_indirect(commands, &raygen_, &miss_, &hit_, &callable, arguments);
}

}  // namespace fire3dv::gpu
