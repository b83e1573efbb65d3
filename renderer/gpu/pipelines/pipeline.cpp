#include "renderer/gpu/pipelines/pipeline.h"

#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/gpu/mask/device_mask.h"
#include "shaders/embedded.h"

namespace fire3dv::gpu {
namespace {

VkShaderModule make_shader_module(VkDevice device, std::string_view name) {
  const std::span<const uint32_t> code = shaders::embedded(name);
  FIRE3DV_ASSERT(!code.empty());
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = code.size_bytes();
  info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreateShaderModule(device, &info, nullptr, &module));
  return module;
}

VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module) {
  VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage = stage;
  info.module = module;
  info.pName = "main";
  return info;
}

VkDeviceSize align_up(VkDeviceSize value, VkDeviceSize alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

// See PipelineKeeper.
std::optional<std::string> describe(Device& device, std::span<const VkDescriptorSetLayout> sets) {
  std::string text;
  for (const VkDescriptorSetLayout set : sets) {
    const std::optional<std::string> description = device.pipeline_keeper().description(set);
    if (!description) return std::nullopt;
    text += *description + "; ";
  }
  return text;
}

// Empty: the pipeline is not kept.
template <typename... Texts>
std::string key_of(Device& device, VkPipelineLayout layout, std::span<const uint32_t> numbers,
                   const Texts&... texts) {
  const std::optional<std::string> description = device.pipeline_keeper().description(layout);
  if (!device.pipeline_keeper().keeps() || !description) return {};
  std::string key = *description;
  for (const std::string_view text : {std::string_view(texts)...}) key += std::string(text) + ": ";
  for (const uint32_t number : numbers) key += std::to_string(number) + ' ';
  return key;
}

// Returns the kept pipeline of the key, or that of make.
Pipeline kept_or_made(Device& device, const std::string& key, PipelineMaking::Make make) {
  if (key.empty()) return {device, make()};
  std::shared_ptr<PipelineMaking> making = device.pipeline_keeper().find(key);
  if (!making) {
    making = std::make_shared<PipelineMaking>(std::move(make));
    making->get();  // failures are not kept
    device.pipeline_keeper().keep(key, making);
  }
  Pipeline pipeline(device, std::move(making));
  pipeline.get();
  return pipeline;
}

// Drivers that emulate ray tracing in compute share undocumented state between devices, so creation is
// serialised.
std::mutex& ray_pipeline_creation() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

ShaderModule create_shader_module(Device& device, std::string_view name) {
  return ShaderModule(device, make_shader_module(device.handle(), name));
}

PipelineLayout create_pipeline_layout(Device& device, std::span<const VkDescriptorSetLayout> sets) {
  VkPushConstantRange range{VK_SHADER_STAGE_ALL, 0, kPushConstantBytes};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = static_cast<uint32_t>(sets.size());
  info.pSetLayouts = sets.data();
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &range;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  FIRE3DV_VK(vkCreatePipelineLayout(device.handle(), &info, nullptr, &layout));
  if (const std::optional<std::string> description = describe(device, sets))
    device.pipeline_keeper().describe(layout, *description);
  return PipelineLayout(device, layout);
}

// The CPU variants assume subgroups of eight lanes.
bool uses_cpu_variants(const Device& device) {
  if (device.report().type != DeviceType::software) return false;
  VkPhysicalDeviceVulkan11Properties subgroups{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroups, {}};
  vkGetPhysicalDeviceProperties2(device.physical(), &properties);
  device_mask().apply(subgroups);
  return subgroups.subgroupSize == 8;
}

namespace {

std::string variant_for(const Device& device, std::string_view shader) {
  constexpr std::string_view kEnd = ".comp";
  if (shader.ends_with(kEnd)) {
    std::string variant = std::string(shader.substr(0, shader.size() - kEnd.size())) + "_cpu.comp";
    if (!shaders::embedded(variant).empty() && uses_cpu_variants(device)) return variant;
  }
  return std::string(shader);
}

}  // namespace

Pipeline create_compute_pipeline(Device& device, VkPipelineLayout layout, std::string_view shader,
                                 Compile make, std::span<const uint32_t> constants) {
  constexpr uint32_t kWord = sizeof(uint32_t);
  const std::string name = variant_for(device, shader);
  const std::string key = key_of(device, layout, constants, name);
  if (!key.empty()) {
    if (std::shared_ptr<PipelineMaking> kept = device.pipeline_keeper().find(key))
      return Pipeline(device, std::move(kept));
  }
  // This runs on another thread: it touches no mutable state of Device and counts no objects.
  auto making =
      std::make_shared<PipelineMaking>([device = device.handle(), cache = device.pipeline_cache(),
                                        layout = device.pipeline_keeper().lasting(layout),
                                        values = std::vector(constants.begin(), constants.end()), name] {
        const VkShaderModule module = make_shader_module(device, name);
        VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
        info.stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module);
        std::vector<VkSpecializationMapEntry> entries;
        for (uint32_t id = 0; id < values.size(); ++id) entries.push_back({id, id * kWord, kWord});
        const VkSpecializationInfo specialization{static_cast<uint32_t>(entries.size()), entries.data(),
                                                  values.size() * kWord, values.data()};
        info.stage.pSpecializationInfo = &specialization;
        info.layout = layout;
        VkPipeline pipeline = VK_NULL_HANDLE;
        const VkResult result = vkCreateComputePipelines(device, cache, 1, &info, nullptr, &pipeline);
        vkDestroyShaderModule(device, module, nullptr);
        check(result, "vkCreateComputePipelines");
        return pipeline;
      });
  if (!key.empty()) device.pipeline_keeper().keep(key, making);
  if (make == Compile::immediately) device.pipeline_makers().add(making);
  if (make == Compile::next) device.pipeline_makers().add_first(making);
  return Pipeline(device, std::move(making));
}

namespace {

VkPipeline make_graphics_pipeline(Device& device, VkPipelineLayout layout,
                                  const GraphicsPipelineInfo& wanted) {
  std::vector<ShaderModule> modules;
  std::vector<VkPipelineShaderStageCreateInfo> stages;
  modules.push_back(create_shader_module(device, wanted.vertex_shader));
  stages.push_back(stage_info(VK_SHADER_STAGE_VERTEX_BIT, modules.back().get()));
  constexpr uint32_t kWord = sizeof(uint32_t);
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t id = 0; id < wanted.fragment_constants.size(); ++id)
    entries.push_back({id, id * kWord, kWord});
  const VkSpecializationInfo specialization{static_cast<uint32_t>(entries.size()), entries.data(),
                                            wanted.fragment_constants.size_bytes(),
                                            wanted.fragment_constants.data()};
  if (!wanted.fragment_shader.empty()) {
    modules.push_back(create_shader_module(device, wanted.fragment_shader));
    stages.push_back(stage_info(VK_SHADER_STAGE_FRAGMENT_BIT, modules.back().get()));
    if (!entries.empty()) stages.back().pSpecializationInfo = &specialization;
  }

  // The shader pulls its vertices.
  VkPipelineVertexInputStateCreateInfo vertex_input{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = wanted.topology;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.lineWidth = 1;
  VkPipelineMultisampleStateCreateInfo multisample{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  multisample.rasterizationSamples = wanted.samples;
  multisample.alphaToCoverageEnable = wanted.alpha_to_coverage;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = VK_TRUE;
  depth.depthWriteEnable = wanted.depth_write;
  depth.depthCompareOp = wanted.depth_compare;

  VkPipelineColorBlendAttachmentState attachment{};
  attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT |
                              VK_COLOR_COMPONENT_A_BIT;
  attachment.blendEnable = wanted.blend;
  attachment.srcColorBlendFactor = attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  attachment.dstColorBlendFactor = attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  if (wanted.is_display_referred) attachment.srcAlphaBlendFactor = VK_BLEND_FACTOR_ZERO;
  if (wanted.dual_source) {
    attachment.dstColorBlendFactor = VK_BLEND_FACTOR_SRC1_COLOR;
    attachment.dstAlphaBlendFactor = VK_BLEND_FACTOR_SRC1_ALPHA;
  }
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = wanted.color_format == VK_FORMAT_UNDEFINED ? 0 : 1;
  blend.pAttachments = &attachment;

  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                           VK_DYNAMIC_STATE_CULL_MODE, VK_DYNAMIC_STATE_FRONT_FACE};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = std::size(dynamic_states);
  dynamic.pDynamicStates = dynamic_states;

  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.colorAttachmentCount = blend.attachmentCount;
  rendering.pColorAttachmentFormats = &wanted.color_format;
  rendering.depthAttachmentFormat = wanted.depth_format;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
  info.stageCount = static_cast<uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &multisample;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  FIRE3DV_VK(
      vkCreateGraphicsPipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &pipeline));
  return pipeline;
}

}  // namespace

Pipeline create_graphics_pipeline(Device& device, VkPipelineLayout layout,
                                  const GraphicsPipelineInfo& wanted) {
  const auto& [vertex, fragment, topology, color, depth, samples, depth_write, depth_compare, blend,
               dual_source, is_display_referred, alpha_to_coverage, constants] = wanted;
  std::vector<uint32_t> numbers;
  for (const int64_t number :
       std::initializer_list<int64_t>{topology, color, depth, samples, depth_write, depth_compare, blend,
                                      dual_source, is_display_referred, alpha_to_coverage})
    numbers.push_back(static_cast<uint32_t>(number));
  numbers.insert(numbers.end(), constants.begin(), constants.end());
  return kept_or_made(device, key_of(device, layout, numbers, vertex, fragment),
                      [&] { return make_graphics_pipeline(device, layout, wanted); });
}

RayPipeline::RayPipeline(Device& device, VkPipelineLayout layout, std::string_view raygen,
                         std::string_view miss, std::string_view any_hit, std::string_view closest_hit,
                         std::span<const uint32_t> constants)
    : device_(&device) {
  constexpr uint32_t kWord = sizeof(uint32_t);
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t id = 0; id < constants.size(); ++id) entries.push_back({id, id * kWord, kWord});
  const VkSpecializationInfo specialization{static_cast<uint32_t>(entries.size()), entries.data(),
                                            constants.size() * kWord, constants.data()};
  const auto make = [&] {
    std::vector<ShaderModule> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    const auto add = [&](VkShaderStageFlagBits stage, std::string_view shader) {
      modules.push_back(create_shader_module(device, shader));
      stages.push_back(stage_info(stage, modules.back().get()));
      stages.back().pSpecializationInfo = &specialization;
      return static_cast<uint32_t>(stages.size() - 1);
    };
    std::array<VkRayTracingShaderGroupCreateInfoKHR, 3> groups{};
    for (VkRayTracingShaderGroupCreateInfoKHR& group : groups) {
      group = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
      group.type = VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR;
      group.generalShader = group.anyHitShader = VK_SHADER_UNUSED_KHR;
      group.closestHitShader = group.intersectionShader = VK_SHADER_UNUSED_KHR;
    }
    groups[0].generalShader = add(VK_SHADER_STAGE_RAYGEN_BIT_KHR, raygen);
    groups[1].generalShader = add(VK_SHADER_STAGE_MISS_BIT_KHR, miss);
    groups[2].type = VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR;
    groups[2].anyHitShader = add(VK_SHADER_STAGE_ANY_HIT_BIT_KHR, any_hit);
    if (!closest_hit.empty())
      groups[2].closestHitShader = add(VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, closest_hit);
    VkRayTracingPipelineCreateInfoKHR info{VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
    info.stageCount = static_cast<uint32_t>(stages.size());
    info.pStages = stages.data();
    info.groupCount = groups.size();
    info.pGroups = groups.data();
    info.maxPipelineRayRecursionDepth = 1;
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    {
      const std::scoped_lock one_device(ray_pipeline_creation());
      FIRE3DV_VK(device.functions().create_ray_tracing_pipelines(
          device.handle(), VK_NULL_HANDLE, device.pipeline_cache(), 1, &info, nullptr, &pipeline));
    }
    return pipeline;
  };
  pipeline_ =
      kept_or_made(device, key_of(device, layout, constants, raygen, miss, any_hit, closest_hit), make);

  const auto& limits = device.ray_pipeline_limits();
  const VkDeviceSize stride =
      align_up(align_up(limits.shaderGroupHandleSize, limits.shaderGroupHandleAlignment),
               limits.shaderGroupBaseAlignment);
  std::vector<std::byte> handles(size_t{3} * limits.shaderGroupHandleSize);
  FIRE3DV_VK(device.functions().get_shader_group_handles(device.handle(), pipeline_.get(), 0, 3,
                                                         handles.size(), handles.data()));
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

Digest device_kind(const VkPhysicalDeviceProperties& device, std::string_view beginning) {
  std::string text = std::string(device.deviceName) + '\0';
  for (const uint32_t number : {device.vendorID, device.deviceID, device.driverVersion, device.apiVersion})
    text += std::to_string(number) + '\0';
  text += hex(device.pipelineCacheUUID);
  for (const std::string_view name : shaders::names()) {
    if (!name.starts_with(beginning)) continue;
    const std::span<const uint32_t> code = shaders::embedded(name);
    text += name;
    text.append(reinterpret_cast<const char*>(code.data()), code.size_bytes());
  }
  return digest_of(std::as_bytes(std::span(text)));
}

}  // namespace fire3dv::gpu
