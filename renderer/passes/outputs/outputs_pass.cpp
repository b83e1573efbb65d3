#include "renderer/passes/outputs/outputs_pass.h"

#include <algorithm>

#include "renderer/passes/outputs/silhouettes.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Memory limit of camera histories; the minimum count of snapshots applies first.
constexpr VkDeviceSize kMaxSnapshotBytes = VkDeviceSize{256} << 20;
constexpr size_t kMinSnapshots = 8;

// Vertices that deform; those of a scene's deformed nodes follow all others.
struct DeformingVertices {
  uint32_t first = 0;
  VkDeviceSize offset = 0, bytes = 0;  // in the positions of a world
};

DeformingVertices deforming_vertices(const GpuScene& scene) {
  if (scene.deformed.nodes.empty()) return {};
  const uint32_t first = scene.geometry[scene.deformed.nodes[0].first_primitive].first_vertex;
  const VkDeviceSize offset = first * sizeof(glm::vec3);
  return {first, offset, scene.vertices[0].positions.size_bytes - offset};
}

VkDeviceSize node_snapshot_bytes(const GpuScene& scene) {
  return (scene.world_count - 1) * scene.node_bytes + scene.node_facts_offset;
}

VkDeviceSize snapshot_bytes(const GpuScene& scene) {
  return node_snapshot_bytes(scene) + scene.world_count * deforming_vertices(scene).bytes;
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
      surface_pipeline_(gpu::create_compute_pipeline(
          device, layout, samples == 4 ? "outputs_surface_4.comp" : "outputs_surface_1.comp",
          gpu::Compile::on_first_use)),
      silhouettes_(device, layout, samples),
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
  if (outputs.needs_last_image() && !current_snapshot_) (void)free_snapshot(snapshot_bytes(scene));
  places_ = lay_out_planes(outputs, extent.width, extent.height * views);
  if (outputs.has(wire::kAmodal))
    add_silhouettes(places_, scene.mesh_node_count, extent.width, extent.height);
  const VkDeviceSize bytes = bytes_of(places_);
  if (bytes == 0 || (planes_ && planes_.size_bytes >= bytes)) return;
  planes_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

VkDeviceSize OutputsPass::view_bytes(ImageOutput output) const {
  return VkDeviceSize{wire::info_of(output).element_bytes} * extent_.width * extent_.height;
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
    return first ? first + view * view_bytes(output) : 0;
  };
  gpu_types::OutputsWanted parameters{};
  parameters.depth = address(wire::kDepthF32);
  parameters.instance = address(wire::kInstanceU32);
  parameters.semantic = address(wire::kSemanticU32);
  parameters.normal = address(wire::kNormal);
  parameters.motion = address(wire::kMotion);
  parameters.albedo = address(wire::kAlbedoF16);
  parameters.roughness = address(wire::kRoughnessF32);
  parameters.metallic = address(wire::kMetallicF32);
  parameters.position = address(wire::kPositionF32);
  parameters.occlusion = address(wire::kOcclusionU32);
  parameters.labels = labels_.address;
  if (last) {
    const GpuScene& scene = source.gpu_scene;
    const DeformingVertices deforming = deforming_vertices(scene);
    const uint32_t world = source.views[view].world;
    parameters.last_world_from_node = last->poses->address + world * scene.node_bytes;
    if (deforming.bytes != 0)
      parameters.last_positions = last->poses->address + node_snapshot_bytes(scene) + world * deforming.bytes;
    parameters.first_deforming_vertex = deforming.first;
    const bool has_depth = last->depth && last->depth_size == glm::uvec2(extent_.width, extent_.height);
    parameters.last_depth = has_depth ? last->depth->address : 0;
    parameters.last_clip_from_world = last->clip_from_world;
    parameters.last_eye_world = last->eye_world;
    parameters.last_look_world = last->look_world;
    parameters.last_world_from_ndc_x = last->world_from_ndc_x;
    parameters.last_world_from_ndc_y = last->world_from_ndc_y;
    parameters.last_world_from_ndc_origin = last->world_from_ndc_origin;
  }
  parameters.look_world = source.views[view].look_world;
  parameters.orthographic = source.views[view].orthographic ? 1 : 0;
  return parameters;
}

void OutputsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                         std::span<CameraHistory> histories) {
  if (!labels_) upload_labels(recorder, staging, source);
  const SilhouettesPass::Source shapes{source.scene,   source.gpu_scene,   source.visibility,
                                       source.globals, source.label_alpha, extent_};
  gpu::Buffer* const labelled = silhouettes_.overlay_blended(recorder, staging, shapes);
  write(recorder, staging, source, labelled ? *labelled : source.visibility, histories);
  for (const PlaneRange& place : places_) {
    if (place.output == wire::kAmodal)
      silhouettes_.draw(recorder, staging, shapes, {planes_, place.offset_bytes, place.size_bytes});
  }
  if (address_of(wire::kMotion) || address_of(wire::kOcclusionU32))
    update_histories(recorder, source, histories);
}

void OutputsPass::write(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                        gpu::Buffer& visibility, std::span<CameraHistory> histories) {
  std::vector<Use> uses{Use(visibility, access::compute_read), Use(labels_, access::compute_read),
                        Use(planes_, access::compute_write)};
  source.gpu_scene.add_reads(uses, access::compute_read);
  const VkDeviceSize visibility_bytes = VkDeviceSize{8} * samples_ * extent_.width * extent_.height;
  std::vector<gpu_types::OutputsPush> pushes;
  for (uint32_t view = 0; view < source.views.size(); ++view) {
    CameraHistory* const last =
        view < histories.size() && histories[view].scene == scenes_ ? &histories[view] : nullptr;
    const bool listed = last && view > 0 && histories[view - 1].poses == last->poses;
    if (last && !listed) uses.emplace_back(*last->poses, access::compute_read);
    if (last && last->depth) uses.emplace_back(*last->depth, access::compute_read);
    const gpu_types::OutputsWanted parameters = make_parameters(source, view, last);
    pushes.push_back({source.globals[view], visibility.address + view * visibility_bytes,
                      staging.write(std::span<const gpu_types::OutputsWanted>(&parameters, 1)).address});
  }
  ImageOutputs outputs(0);
  for (const PlaneRange& place : places_) outputs.add(place.output);
  const gpu::Pipeline& pipeline = outputs.has_surface_planes() ? surface_pipeline_ : pipeline_;
  recorder.pass("outputs", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    const VkDescriptorSet set = source.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    for (const gpu_types::OutputsPush& push : pushes) {
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, 1);
    }
  });
}

void OutputsPass::update_histories(gpu::Recorder& recorder, const Source& source,
                                   std::span<CameraHistory> histories) {
  if (histories.empty()) return;
  if (!current_snapshot_) keep_poses(recorder, source.gpu_scene);
  for (size_t v = 0; v < histories.size(); ++v) {
    const View& view = source.views[v];
    CameraHistory& history = histories[v];
    history.poses = current_snapshot_;
    history.clip_from_world = view.clip_from_world;
    history.eye_world = view.eye_world;
    history.look_world = view.look_world;
    history.world_from_ndc_x = view.world_from_ndc_x;
    history.world_from_ndc_y = view.world_from_ndc_y;
    history.world_from_ndc_origin = view.world_from_ndc_origin;
    history.scene = scenes_;
  }
  if (address_of(wire::kOcclusionU32) && address_of(wire::kDepthF32)) keep_depths(recorder, histories);
}

void OutputsPass::keep_poses(gpu::Recorder& recorder, GpuScene& scene) {
  const VkDeviceSize node_bytes = node_snapshot_bytes(scene);
  const DeformingVertices deforming = deforming_vertices(scene);
  current_snapshot_ = free_snapshot(snapshot_bytes(scene));
  if (node_bytes == 0) return;
  std::vector<Use> uses{Use(scene.world_from_node, access::transfer_read),
                        Use(*current_snapshot_, access::transfer_write)};
  if (deforming.bytes != 0)
    for (VertexBuffers& vertices : scene.vertices)
      uses.emplace_back(vertices.positions, access::transfer_read);
  recorder.pass("keep poses", uses, [&](VkCommandBuffer commands) {
    const VkBufferCopy nodes{0, 0, node_bytes};
    vkCmdCopyBuffer(commands, scene.world_from_node.get(), current_snapshot_->get(), 1, &nodes);
    if (deforming.bytes == 0) return;
    for (uint32_t world = 0; world < scene.world_count; ++world) {
      const VkBufferCopy positions{deforming.offset, node_bytes + world * deforming.bytes, deforming.bytes};
      vkCmdCopyBuffer(commands, scene.vertices_of(world).positions.get(), current_snapshot_->get(), 1,
                      &positions);
    }
  });
}

void OutputsPass::keep_depths(gpu::Recorder& recorder, std::span<CameraHistory> histories) {
  const VkDeviceSize bytes = view_bytes(wire::kDepthF32);
  const VkDeviceSize first = address_of(wire::kDepthF32) - planes_.address;
  std::vector<Use> uses{Use(planes_, access::transfer_read)};
  for (CameraHistory& history : histories) {
    if (!history.depth) history.depth = std::make_shared<gpu::Buffer>();
    gpu::grow_storage_buffer(device_, *history.depth, bytes);
    history.depth_size = {extent_.width, extent_.height};
    uses.emplace_back(*history.depth, access::transfer_write);
  }
  recorder.pass("keep depths", uses, [&](VkCommandBuffer commands) {
    for (size_t view = 0; view < histories.size(); ++view) {
      const VkBufferCopy copy{first + view * bytes, 0, bytes};
      vkCmdCopyBuffer(commands, planes_.get(), histories[view].depth->get(), 1, &copy);
    }
  });
}

}  // namespace fire3dv::passes
