#include "renderer/passes/outputs/silhouettes_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/passes/outputs/silhouettes.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Least alpha of the labelled surface, see gpu_types::LabelPart.
float alpha_limit_of(const scene::Material& material, float label_alpha) {
  if (material.alpha_mode == scene::AlphaMode::mask) return FIRE3DV_ALPHA_CUTOFF;
  if (material.alpha_mode == scene::AlphaMode::opaque) return 0;
  // More than the limit, and no denormal number, which a device may take for 0.
  return std::max(std::nextafter(label_alpha, 2.0f), std::numeric_limits<float>::min());
}

std::vector<gpu_types::LabelPart> drawn_parts(const SilhouettesPass::Shown& shown) {
  const scene::Scene& scene = shown.scene;
  const GpuScene& gpu_scene = shown.gpu_scene;
  std::vector<gpu_types::LabelPart> parts(gpu_scene.part_count, {FIRE3DV_NO_INDEX, 0, 0});
  uint32_t slot = 0;
  for (const uint32_t node : nodes_with_silhouettes(scene)) {
    const scene::Mesh& mesh = scene.meshes[scene.nodes[node].mesh];
    const uint32_t first_part = gpu_scene.first_part_of_node[node];
    for (uint32_t i = 0; i < mesh.primitive_count && !gpu_scene.is_hidden(node); ++i) {
      const scene::Primitive& primitive = scene.primitives[mesh.first_primitive + i];
      if (primitive.topology != scene::Topology::triangles) continue;
      const float limit = alpha_limit_of(scene.materials[primitive.material], shown.label_alpha);
      if (limit > 0 && largest_alpha(scene, shown.edits, node, primitive) < limit) continue;
      const bool is_overlaid = (gpu_scene.part_flags[first_part + i] & FIRE3DV_PART_FORWARD_ONLY) != 0;
      parts[first_part + i] = {slot, is_overlaid ? 1u : 0u, limit};
    }
    ++slot;
  }
  return parts;
}

bool any_overlaid(const std::vector<gpu_types::LabelPart>& parts) {
  return std::ranges::any_of(parts, [](const gpu_types::LabelPart& part) { return part.is_overlaid != 0; });
}

bool may_have_overlaid(const GpuScene& scene) {
  return scene.has_forward_only && scene.has_blended_triangles;
}

}  // namespace

SilhouettesPass::SilhouettesPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : device_(device),
      layout_(layout),
      pipeline_(gpu::create_compute_pipeline(device, layout,
                                             samples == 4 ? "silhouettes_4.comp" : "silhouettes_1.comp",
                                             gpu::Compile::on_first_use)),
      samples_(samples) {}

VkDeviceSize SilhouettesPass::view_bytes(VkExtent2D extent) const {
  return VkDeviceSize{8} * samples_ * extent.width * extent.height;
}

void SilhouettesPass::make_room(const Shown& shown, VkExtent2D extent, uint32_t views) {
  const VkDeviceSize bytes = views * view_bytes(extent);
  if (labelled_.size_bytes >= bytes || !may_have_overlaid(shown.gpu_scene)) return;
  if (any_overlaid(drawn_parts(shown))) gpu::grow_storage_buffer(device_, labelled_, bytes);
}

gpu::Buffer* SilhouettesPass::overlay_blended(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                              const Source& source) {
  if (!may_have_overlaid(source.gpu_scene)) return nullptr;
  const std::vector<gpu_types::LabelPart> parts = drawn_parts(source.shown);
  if (!any_overlaid(parts)) return nullptr;
  const VkDeviceSize of_view = view_bytes(source.extent), bytes = of_view * source.globals.size();
  gpu::grow_storage_buffer(device_, labelled_, bytes);
  recorder.pass("copy ids",
                {Use(source.visibility, access::transfer_read), Use(labelled_, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  const VkBufferCopy copy{0, 0, bytes};
                  vkCmdCopyBuffer(commands, source.visibility.get(), labelled_.get(), 1, &copy);
                });
  const VkDeviceAddress of_parts = staging.write(std::span<const gpu_types::LabelPart>(parts)).address;
  std::vector<gpu_types::SilhouettesWanted> wanted;
  for (size_t view = 0; view < source.globals.size(); ++view) {
    wanted.push_back({source.globals[view], of_parts, 0, 0, labelled_.address + view * of_view,
                      source.gpu_scene.lod0_cluster_instance_count});
  }
  dispatch(recorder, staging, "blended labels", source.gpu_scene, labelled_, wanted);
  return &labelled_;
}

void SilhouettesPass::draw(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                           const Bits& bits) {
  if (bits.bytes == 0) return;
  FIRE3DV_ASSERT(source.globals.size() == 1);
  const std::vector<gpu_types::LabelPart> parts = drawn_parts(source.shown);
  const VkDeviceAddress of_parts = staging.write(std::span<const gpu_types::LabelPart>(parts)).address;
  recorder.pass("clear silhouettes", {Use(bits.buffer, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  vkCmdFillBuffer(commands, bits.buffer.get(), bits.offset, bits.bytes, 0);
                });
  const VkDeviceAddress first = bits.buffer.address + bits.offset;
  const VkDeviceSize truncated_bytes = sizeof(uint32_t) * silhouette_words(source.gpu_scene.mesh_node_count);
  const gpu_types::SilhouettesWanted wanted{source.globals[0],
                                            of_parts,
                                            first,
                                            first + bits.bytes - truncated_bytes,
                                            0,
                                            source.gpu_scene.lod0_cluster_instance_count};
  dispatch(recorder, staging, "silhouettes", source.gpu_scene, bits.buffer, std::span(&wanted, 1));
}

void SilhouettesPass::dispatch(gpu::Recorder& recorder, gpu::StagingRing& staging, const char* name,
                               GpuScene& scene, gpu::Buffer& written,
                               std::span<const gpu_types::SilhouettesWanted> wanted) {
  const uint32_t clusters = scene.lod0_cluster_instance_count;
  if (clusters == 0) return;
  std::vector<Use> uses{Use(written, access::compute_write)};
  scene.add_reads(uses, access::compute_read);
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    const VkDescriptorSet set = scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    for (const gpu_types::SilhouettesWanted& of_view : wanted) {
      const gpu_types::SilhouettesPush push{
          staging.write(std::span<const gpu_types::SilhouettesWanted>(&of_view, 1)).address};
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, std::min(clusters, 65535u), (clusters + 65534) / 65535, 1);
    }
  });
}

}  // namespace fire3dv::passes
