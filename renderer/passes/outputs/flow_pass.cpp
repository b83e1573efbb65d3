#include "renderer/passes/outputs/flow_pass.h"

#include <algorithm>

#include "shaders/shared/flow_types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// One bit per node; empty: none is hidden.
std::vector<uint32_t> hidden_bits(const GpuScene& scene) {
  if (std::ranges::find(scene.hidden, true) == scene.hidden.end()) return {};
  std::vector<uint32_t> bits((scene.hidden.size() + 31) / 32);
  for (size_t node = 0; node < scene.hidden.size(); ++node)
    if (scene.hidden[node]) bits[node / 32] |= 1u << (node % 32);
  return bits;
}

}  // namespace

VkDeviceSize surfaces_bytes(VkExtent2D extent) {
  return sizeof(gpu_types::SurfaceReference) * extent.width * extent.height;
}

FlowPass::FlowPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : device_(device),
      layout_(layout),
      surfaces_pipeline_(gpu::create_compute_pipeline(
          device, layout, samples == 4 ? "surface_references_4.comp" : "surface_references_1.comp",
          gpu::Compile::on_first_use)),
      pipeline_(gpu::create_compute_pipeline(device, layout, "flow.comp", gpu::Compile::on_first_use)) {}

void FlowPass::keep_surfaces(gpu::Recorder& recorder, const Shown& shown, gpu::Buffer& surfaces) {
  const gpu_types::SurfaceReferencesPush push{shown.globals, shown.visibility.address, surfaces.address,
                                              shown.view.look_world, shown.view.orthographic ? 1u : 0u};
  std::vector<Use> uses{Use(shown.visibility, access::compute_read), Use(surfaces, access::compute_write)};
  shown.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("keep surfaces", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, surfaces_pipeline_.get());
    const VkDescriptorSet set = shown.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (shown.extent.width + 7) / 8, (shown.extent.height + 7) / 8, 1);
  });
}

void FlowPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                      const CameraHistory& earlier) {
  FIRE3DV_ASSERT(result_.size_bytes >= flow_bytes(source.extent));  // make_room()
  const std::vector<uint32_t> hidden = hidden_bits(source.gpu_scene);
  gpu_types::FlowWanted wanted{};
  wanted.globals = source.globals;
  wanted.references = earlier.surfaces->address;
  if (!hidden.empty()) wanted.hidden = staging.write(std::span<const uint32_t>(hidden)).address;
  wanted.labels = source.labels.address;
  wanted.depth = source.depth;
  wanted.flow = result_.address;
  wanted.occlusion = result_.address + flow_bytes(source.extent) / 12 * 8;
  wanted.earlier_world_from_ndc_x = earlier.world_from_ndc_x;
  wanted.earlier_world_from_ndc_y = earlier.world_from_ndc_y;
  wanted.earlier_world_from_ndc_origin = earlier.world_from_ndc_origin;
  wanted.earlier_orthographic = earlier.orthographic ? 1 : 0;
  wanted.look_world = source.view.look_world;
  wanted.orthographic = source.view.orthographic ? 1 : 0;
  const gpu_types::FlowPush push{staging.write(std::span<const gpu_types::FlowWanted>(&wanted, 1)).address};
  std::vector<Use> uses{Use(result_, access::compute_write), Use(*earlier.surfaces, access::compute_read),
                        Use(source.planes, access::compute_read), Use(source.labels, access::compute_read)};
  source.gpu_scene.add_reads(uses, access::compute_read);
  recorder.pass("flow", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    const VkDescriptorSet set = source.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (source.extent.width + 7) / 8, (source.extent.height + 7) / 8, 1);
  });
}

}  // namespace fire3dv::passes
