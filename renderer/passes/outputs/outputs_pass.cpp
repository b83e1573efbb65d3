#include "renderer/passes/outputs/outputs_pass.h"

#include <algorithm>

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Memory limit of camera histories; the minimum count of snapshots applies first.
constexpr VkDeviceSize kMaxSnapshotBytes = VkDeviceSize{256} << 20;
constexpr size_t kMinSnapshots = 8;

VkDeviceSize snapshot_bytes(const GpuScene& scene) {
  return (scene.world_count - 1) * scene.node_bytes + scene.node_facts_offset;
}

std::vector<gpu_types::PartLabels> label_parts(const scene::Scene& scene, const GpuScene& gpu_scene) {
  std::vector<gpu_types::PartLabels> labels;
  for (const uint32_t node : gpu_scene.nodes_of_parts())
    labels.push_back({node + 1, scene.nodes[node].semantic});
  return labels;
}

}  // namespace

OutputsPass::OutputsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : device_(device),
      layout_(layout),
      pipeline_(gpu::create_compute_pipeline(
          device, layout, samples == 4 ? "outputs_4.comp" : "outputs_1.comp", gpu::Compile::on_first_use)),
      samples_(samples) {}

bool OutputsPass::has_room_for_snapshot(const GpuScene& scene) const {
  if (current_snapshot_) return true;
  const auto referenced = static_cast<size_t>(std::count_if(
      snapshots_.begin(), snapshots_.end(), [](const auto& snapshot) { return snapshot.use_count() > 1; }));
  return referenced < kMinSnapshots || referenced * snapshot_bytes(scene) < kMaxSnapshotBytes;
}

// Returns a snapshot buffer that no history references.
std::shared_ptr<gpu::Buffer> OutputsPass::free_snapshot(VkDeviceSize bytes) {
  std::erase_if(snapshots_, [&](const auto& snapshot) {
    return snapshot.use_count() == 1 && snapshot->size_bytes < bytes;  // of another scene
  });
  for (const std::shared_ptr<gpu::Buffer>& snapshot : snapshots_) {
    if (snapshot.use_count() == 1) return snapshot;
  }
  return snapshots_.emplace_back(std::make_shared<gpu::Buffer>(
      gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device)));
}

void OutputsPass::begin(const ImageOutputs& outputs, const GpuScene& scene, VkExtent2D extent,
                        uint32_t views) {
  extent_ = extent;
  if (outputs.has(wire::kMotion) && !current_snapshot_) (void)free_snapshot(snapshot_bytes(scene));
  places_ = lay_out_planes(outputs, extent.width, extent.height * views);
  const VkDeviceSize bytes = bytes_of(places_);
  if (bytes == 0 || (planes_ && planes_.size_bytes >= bytes)) return;
  planes_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

VkDeviceAddress OutputsPass::address_of(ImageOutput output) const {
  for (const PlaneRange& place : places_) {
    if (place.output == output) return planes_.address + place.offset_bytes;
  }
  return 0;
}

void OutputsPass::upload_labels(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source) {
  const std::vector<gpu_types::PartLabels> labels = label_parts(source.scene, source.gpu_scene);
  const VkDeviceSize bytes = labels.size() * sizeof(gpu_types::PartLabels);
  labels_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  if (bytes == 0) return;
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::PartLabels>(labels));
  recorder.pass("labels", {Use(labels_, access::transfer_write)}, [&](VkCommandBuffer commands) {
    const VkBufferCopy copy{piece.offset, 0, bytes};
    vkCmdCopyBuffer(commands, piece.buffer, labels_.get(), 1, &copy);
  });
}

gpu_types::OutputsWanted OutputsPass::make_parameters(const Source& source, uint32_t view,
                                                      const CameraHistory* last) const {
  const auto address = [&](ImageOutput output) -> VkDeviceAddress {
    const VkDeviceAddress first = address_of(output);
    const VkDeviceSize view_bytes =
        VkDeviceSize{wire::info_of(output).element_bytes} * extent_.width * extent_.height;
    return first ? first + view * view_bytes : 0;
  };
  gpu_types::OutputsWanted parameters{};
  parameters.depth = address(wire::kDepthF32);
  parameters.instance = address(wire::kInstanceU32);
  parameters.semantic = address(wire::kSemanticU32);
  parameters.normal = address(wire::kNormal);
  parameters.motion = address(wire::kMotion);
  parameters.labels = labels_.address;
  parameters.last_world_from_node =
      last ? last->world_from_node->address + source.views[view].world * source.gpu_scene.node_bytes : 0;
  parameters.last_clip_from_world = last ? last->clip_from_world : glm::mat4(1);
  parameters.look_world = source.views[view].look_world;
  parameters.orthographic = source.views[view].orthographic ? 1 : 0;
  return parameters;
}

void OutputsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                         std::span<CameraHistory> histories) {
  if (!labels_) upload_labels(recorder, staging, source);
  std::vector<Use> uses{Use(source.visibility, access::compute_read), Use(labels_, access::compute_read),
                        Use(planes_, access::compute_write)};
  source.gpu_scene.add_reads(uses, access::compute_read);
  const VkDeviceSize view_bytes = VkDeviceSize{8} * samples_ * extent_.width * extent_.height;
  std::vector<gpu_types::OutputsPush> pushes;
  for (uint32_t view = 0; view < source.views.size(); ++view) {
    CameraHistory* const last =
        view < histories.size() && histories[view].scene == scenes_ ? &histories[view] : nullptr;
    const bool listed = last && view > 0 && histories[view - 1].world_from_node == last->world_from_node;
    if (last && !listed) uses.emplace_back(*last->world_from_node, access::compute_read);
    const gpu_types::OutputsWanted parameters = make_parameters(source, view, last);
    pushes.push_back({source.globals[view], source.visibility.address + view * view_bytes,
                      staging.write(std::span<const gpu_types::OutputsWanted>(&parameters, 1)).address});
  }
  recorder.pass("outputs", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    const VkDescriptorSet set = source.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    for (const gpu_types::OutputsPush& push : pushes) {
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, 1);
    }
  });
  if (address_of(wire::kMotion)) update_histories(recorder, source, histories);
}

void OutputsPass::update_histories(gpu::Recorder& recorder, const Source& source,
                                   std::span<CameraHistory> histories) {
  if (histories.empty()) return;
  const VkDeviceSize bytes = snapshot_bytes(source.gpu_scene);
  if (!current_snapshot_) {
    current_snapshot_ = free_snapshot(bytes);
    gpu::Buffer& now = source.gpu_scene.world_from_node;
    if (bytes != 0) {
      recorder.pass("keep poses",
                    {Use(now, access::transfer_read), Use(*current_snapshot_, access::transfer_write)},
                    [&](VkCommandBuffer commands) {
                      const VkBufferCopy copy{0, 0, bytes};
                      vkCmdCopyBuffer(commands, now.get(), current_snapshot_->get(), 1, &copy);
                    });
    }
  }
  for (size_t view = 0; view < histories.size(); ++view)
    histories[view] = {current_snapshot_, source.views[view].clip_from_world, scenes_};
}

}  // namespace fire3dv::passes
