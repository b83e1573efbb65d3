#include "renderer/passes/outputs/outputs_pass.h"

#include <algorithm>
#include <string>

#include "renderer/passes/outputs/silhouettes.h"
#include "renderer/passes/resources/shader_variant.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

// Vertices that deform; those of a scene's deformed nodes follow all others.
struct DeformingVertices {
  uint32_t first = 0;
  VkDeviceSize offset = 0, bytes = 0;  // in the positions of a world
};

DeformingVertices deforming_vertices(const GpuScene& scene) {
  if (scene.deformed.nodes.empty()) return {};
  // Nodes whose meshes have no primitives come with the first primitive of a later node.
  const uint32_t first_primitive = scene.deformed.nodes[0].first_primitive;
  if (first_primitive >= scene.geometry.size()) return {};
  const uint32_t first = scene.geometry[first_primitive].first_vertex;
  const VkDeviceSize offset = first * sizeof(glm::vec3);
  return {first, offset, scene.vertices[0].positions.size_bytes - offset};
}

VkDeviceSize node_snapshot_bytes(const GpuScene& scene) {
  return (scene.world_count - 1) * scene.node_bytes + scene.node_facts_offset;
}

struct ByteRange {
  VkDeviceSize offset, bytes;
};

// Transforms of hidden nodes, in those of a world.
std::vector<ByteRange> hidden_transforms(const GpuScene& scene) {
  constexpr VkDeviceSize kRows = sizeof(gpu_types::AffineRows);
  std::vector<ByteRange> ranges;
  for (uint32_t node = 0; node < scene.hidden.size(); ++node) {
    if (!scene.hidden[node]) continue;
    if (!ranges.empty() && ranges.back().offset + ranges.back().bytes == node * kRows)
      ranges.back().bytes += kRows;
    else
      ranges.push_back({node * kRows, kRows});
  }
  return ranges;
}

// Vertices of hidden nodes, in those of a world that deform.
std::vector<ByteRange> hidden_vertices(const GpuScene& scene, const DeformingVertices& deforming) {
  std::vector<ByteRange> ranges;
  for (size_t i = 0; i < scene.deformed.nodes.size(); ++i) {
    if (!scene.is_hidden(scene.deformed.nodes[i].node)) continue;
    const size_t end = i + 1 < scene.deformed.nodes.size() ? scene.deformed.nodes[i + 1].first_primitive
                                                           : scene.geometry.size();
    for (size_t p = scene.deformed.nodes[i].first_primitive; p < end; ++p) {
      const scene::ClusteredPrimitive& primitive = scene.geometry[p];
      if (primitive.vertex_count > 0)
        ranges.push_back({(primitive.first_vertex - deforming.first) * sizeof(glm::vec3),
                          primitive.vertex_count * sizeof(glm::vec3)});
    }
  }
  return ranges;
}

// Depths that no history has yet.
uint32_t new_depths(const OutputsPass::Images& images) {
  return images.views - std::min(images.views, images.replaced.depths);
}

// Planes that the common shader writes.
struct WrittenPlane {
  ImageOutput output;
  decltype(gpu_types::OutputsWanted::depth) gpu_types::OutputsWanted::*address;
};
constexpr WrittenPlane kWrittenPlanes[] = {{wire::kDepthF32, &gpu_types::OutputsWanted::depth},
                                           {wire::kInstanceU32, &gpu_types::OutputsWanted::instance},
                                           {wire::kSemanticU32, &gpu_types::OutputsWanted::semantic},
                                           {wire::kNormal, &gpu_types::OutputsWanted::normal},
                                           {wire::kMotion, &gpu_types::OutputsWanted::motion},
                                           {wire::kAlbedoF16, &gpu_types::OutputsWanted::albedo},
                                           {wire::kRoughnessF32, &gpu_types::OutputsWanted::roughness},
                                           {wire::kMetallicF32, &gpu_types::OutputsWanted::metallic},
                                           {wire::kPositionF32, &gpu_types::OutputsWanted::position},
                                           {wire::kOcclusionU32, &gpu_types::OutputsWanted::occlusion}};

std::vector<gpu_types::PartLabels> label_parts(const scene::Scene& scene, const GpuScene& gpu_scene) {
  std::vector<gpu_types::PartLabels> labels;
  for (const uint32_t node : gpu_scene.nodes_of_parts())
    labels.push_back({node + 1, scene.nodes[node].semantic});
  return labels;
}

}  // namespace

VkDeviceSize snapshot_bytes(const GpuScene& scene) {
  return node_snapshot_bytes(scene) + scene.world_count * deforming_vertices(scene).bytes;
}

OutputsPass::OutputsPass(gpu::Device& device, VkPipelineLayout layout, uint32_t samples)
    : device_(device),
      layout_(layout),
      silhouettes_(device, layout, samples),
      flow_(device, layout, samples),
      samples_(samples) {
  for (const bool surfaces : {false, true}) make_pipeline(surfaces, false, gpu::Compile::on_first_use);
}

void OutputsPass::make_pipeline(bool surfaces, bool common, gpu::Compile when) {
  gpu::Pipeline& pipeline = pipelines_[surfaces][common];
  if (pipeline) return;
  ShaderVariant variant;
  variant.several_worlds = common;
  const std::string shader =
      std::string(surfaces ? "outputs_surface" : "outputs") + (samples_ == 4 ? "_4.comp" : "_1.comp");
  pipeline = gpu::create_compute_pipeline(device_, layout_, shader, when, variant.constants());
}

Result<void> OutputsPass::check_room_for_histories(const Images& images, const GpuScene& scene) const {
  const ImageOutputs& outputs = images.outputs;
  const auto has_room = [](const Pool& pool, size_t more, VkDeviceSize bytes) {
    if (more == 0) return true;
    VkDeviceSize all_bytes = more * bytes;
    for (const auto& buffer : pool) {
      if (buffer.use_count() == 1) continue;
      all_bytes += buffer->size_bytes;
      ++more;
    }
    return more <= kMinHistories || all_bytes <= kMaxHistoryBytes;
  };
  const std::string limit = std::to_string(kMaxHistoryBytes >> 20) + " MiB";
  const bool needs_poses = outputs.needs_last_image() && !current_snapshot_ && !images.replaced.poses;
  if (needs_poses && !has_room(snapshots_, 1, snapshot_bytes(scene)))
    return Error{"images with motion or occlusion that were drawn at different moments keep more than " +
                 limit +
                 " of poses on the device: request these outputs with every frame, or in fewer requests"};
  if (images.keeps_surfaces && !has_room(surfaces_, 1, surfaces_bytes(images.extent)))
    return Error{"images that flow is measured from keep more than " + limit +
                 " of surfaces on the device: choose smaller images, or fewer frames between two of them"};
  const VkDeviceSize depth_bytes = VkDeviceSize{sizeof(float)} * images.extent.width * images.extent.height;
  if (outputs.has(wire::kOcclusionU32) && !has_room(depths_, new_depths(images), depth_bytes))
    return Error{"images with occlusion keep more than " + limit +
                 " of depths on the device: request occlusion of fewer or smaller images"};
  return {};
}

// Returns a buffer that no history references.
std::shared_ptr<gpu::Buffer> OutputsPass::take_free(Pool& pool, VkDeviceSize bytes) {
  std::erase_if(pool, [&](const auto& buffer) {
    return buffer.use_count() == 1 && buffer->size_bytes < bytes;  // of another scene or size
  });
  for (const std::shared_ptr<gpu::Buffer>& buffer : pool) {
    if (buffer.use_count() == 1) return buffer;
  }
  return pool.emplace_back(std::make_shared<gpu::Buffer>(
      gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device)));
}

void OutputsPass::begin(const Images& images, const SilhouettesPass::Shown& shown) {
  const GpuScene& scene = shown.gpu_scene;
  const ImageOutputs& outputs = images.outputs;
  extent_ = images.extent;
  if (images.has_history && outputs.needs_last_image() && !current_snapshot_)
    (void)take_free(snapshots_, snapshot_bytes(scene));
  if (images.has_history && outputs.has(wire::kOcclusionU32)) {
    Pool taken;
    while (taken.size() < new_depths(images))
      taken.push_back(take_free(depths_, view_bytes(wire::kDepthF32)));
  }
  if (images.keeps_surfaces) (void)take_free(surfaces_, surfaces_bytes(extent_));
  if (images.has_flow) flow_.make_room(extent_);
  if (images.common && outputs.has_id_planes())
    make_pipeline(outputs.has_surface_planes(), true, gpu::Compile::next);
  if (outputs.has_id_planes()) silhouettes_.make_room(shown, extent_, images.views);
  places_ = lay_out_planes(outputs, extent_.width, extent_.height * images.views);
  if (outputs.has(wire::kAmodal))
    add_silhouettes(places_, scene.mesh_node_count, extent_.width, extent_.height);
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

gpu_types::OutputsWanted OutputsPass::wanted_of_first_view() const {
  gpu_types::OutputsWanted parameters{};
  for (const WrittenPlane& plane : kWrittenPlanes) parameters.*plane.address = address_of(plane.output);
  parameters.labels = labels_.address;
  return parameters;
}

void OutputsPass::set_view(gpu_types::OutputsWanted& parameters, const Source& source, uint32_t view,
                           const CameraHistory* last) const {
  for (const WrittenPlane& plane : kWrittenPlanes) {
    VkDeviceAddress& address = parameters.*plane.address;
    if (address) address += view * view_bytes(plane.output);
  }
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
    parameters.last_orthographic = last->orthographic ? 1 : 0;
  }
  parameters.look_world = source.views[view].look_world;
  parameters.orthographic = source.views[view].orthographic ? 1 : 0;
}

void OutputsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                         std::span<CameraHistory> histories) {
  if (!labels_) upload_labels(recorder, staging, source);
  const SilhouettesPass::Source shapes{{source.scene, source.gpu_scene, source.label_alpha, source.edits},
                                       source.gpu_scene,
                                       source.visibility,
                                       source.globals,
                                       extent_};
  gpu::Buffer* const labelled = silhouettes_.overlay_blended(recorder, staging, shapes);
  write(recorder, staging, source, labelled ? *labelled : source.visibility, histories);
  for (const PlaneRange& place : places_) {
    if (place.output == wire::kAmodal)
      silhouettes_.draw(recorder, staging, shapes, {planes_, place.offset_bytes, place.size_bytes});
  }
  if (source.flow_from) record_flow(recorder, staging, source);
  if (address_of(wire::kMotion) || address_of(wire::kOcclusionU32))
    update_histories(recorder, source, histories);
  for (CameraHistory& history : histories) {
    history.surfaces.reset();
    if (source.keeps_surfaces && source.views.size() == 1)
      keep_surfaces(recorder, source, labelled ? *labelled : source.visibility, history);
  }
}

void OutputsPass::record_flow(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source) {
  const CameraHistory& earlier = *source.flow_from;
  const bool is_same = earlier.scene == scenes_ && earlier.surfaces &&
                       earlier.depth_size == glm::uvec2(extent_.width, extent_.height);
  FIRE3DV_ASSERT(is_same && source.views.size() == 1 && address_of(wire::kDepthF32));
  flow_.record(recorder, staging,
               {source.gpu_scene, source.views[0], source.globals[0], planes_, address_of(wire::kDepthF32),
                labels_, extent_},
               earlier);
}

void OutputsPass::keep_surfaces(gpu::Recorder& recorder, const Source& source, gpu::Buffer& visibility,
                                CameraHistory& history) {
  history.surfaces = take_free(surfaces_, surfaces_bytes(extent_));  // of begin()
  flow_.keep_surfaces(recorder, {source.gpu_scene, source.views[0], source.globals[0], visibility, extent_},
                      *history.surfaces);
}

void OutputsPass::write(gpu::Recorder& recorder, gpu::StagingRing& staging, const Source& source,
                        gpu::Buffer& visibility, std::span<CameraHistory> histories) {
  std::vector<Use> uses{Use(visibility, access::compute_read), Use(labels_, access::compute_read),
                        Use(planes_, access::compute_write)};
  source.gpu_scene.add_reads(uses, access::compute_read);
  const VkDeviceSize visibility_bytes = VkDeviceSize{8} * samples_ * extent_.width * extent_.height;
  std::vector<gpu_types::OutputsPush> pushes;
  std::vector<gpu_types::OutputsWanted> wanted;
  const gpu_types::OutputsWanted first = wanted_of_first_view();
  pushes.reserve(source.views.size());
  wanted.reserve(source.views.size());
  for (uint32_t view = 0; view < source.views.size(); ++view) {
    CameraHistory* const last =
        view < histories.size() && histories[view].scene == scenes_ ? &histories[view] : nullptr;
    const bool listed = last && view > 0 && histories[view - 1].poses == last->poses;
    if (last && !listed) uses.emplace_back(*last->poses, access::compute_read);
    if (last && last->depth) uses.emplace_back(*last->depth, access::compute_read);
    set_view(wanted.emplace_back(first), source, view, last);
    pushes.push_back({source.globals[view], visibility.address + view * visibility_bytes, 0});
  }
  const VkDeviceAddress parameters = staging.write(std::span<const gpu_types::OutputsWanted>(wanted)).address;
  for (size_t view = 0; view < pushes.size(); ++view)
    pushes[view].wanted = parameters + view * sizeof(gpu_types::OutputsWanted);
  ImageOutputs outputs(0);
  for (const PlaneRange& place : places_) outputs.add(place.output);
  const gpu::Pipeline& pipeline = pipelines_[outputs.has_surface_planes() ? 1 : 0][source.common ? 1 : 0];
  uint32_t layers = 1;
  if (source.common) {
    layers = static_cast<uint32_t>(pushes.size());
    pushes = {{staging.write(std::span<const gpu_types::OutputsPush>(pushes)).address, 0, 0}};
  }
  recorder.pass("outputs", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
    const VkDescriptorSet set = source.gpu_scene.textures.set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set, 0, nullptr);
    for (const gpu_types::OutputsPush& push : pushes) {
      vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
      vkCmdDispatch(commands, (extent_.width + 7) / 8, (extent_.height + 7) / 8, layers);
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
    history.orthographic = view.orthographic;
    history.scene = scenes_;
  }
  if (address_of(wire::kOcclusionU32) && address_of(wire::kDepthF32)) {
    keep_depths(recorder, histories);
  } else {
    for (CameraHistory& history : histories) history.depth.reset();  // of an earlier image
  }
}

void OutputsPass::keep_poses(gpu::Recorder& recorder, GpuScene& scene) {
  const VkDeviceSize node_bytes = node_snapshot_bytes(scene);
  const DeformingVertices deforming = deforming_vertices(scene);
  current_snapshot_ = take_free(snapshots_, snapshot_bytes(scene));
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
  mark_hidden(recorder, scene);
}

// Nodes that this frame hides get places that are no numbers.
void OutputsPass::mark_hidden(gpu::Recorder& recorder, GpuScene& scene) {
  if (std::ranges::find(scene.hidden, true) == scene.hidden.end()) return;
  const VkDeviceSize node_bytes = node_snapshot_bytes(scene);
  const DeformingVertices deforming = deforming_vertices(scene);
  const std::vector<ByteRange> transforms = hidden_transforms(scene),
                               vertices = hidden_vertices(scene, deforming);
  recorder.pass("mark hidden", {Use(*current_snapshot_, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  for (uint32_t world = 0; world < scene.world_count; ++world) {
                    for (const ByteRange& range : transforms)
                      vkCmdFillBuffer(commands, current_snapshot_->get(),
                                      world * scene.node_bytes + range.offset, range.bytes, FIRE3DV_NO_PLACE);
                    for (const ByteRange& range : vertices)
                      vkCmdFillBuffer(commands, current_snapshot_->get(),
                                      node_bytes + world * deforming.bytes + range.offset, range.bytes,
                                      FIRE3DV_NO_PLACE);
                  }
                });
}

void OutputsPass::keep_depths(gpu::Recorder& recorder, std::span<CameraHistory> histories) {
  const VkDeviceSize bytes = view_bytes(wire::kDepthF32);
  const VkDeviceSize first = address_of(wire::kDepthF32) - planes_.address;
  std::vector<Use> uses{Use(planes_, access::transfer_read)};
  for (CameraHistory& history : histories) {
    // The depth of the last image was read by write().
    if (!can_replace_depth(history, {extent_.width, extent_.height}))
      history.depth = take_free(depths_, bytes);  // of begin()
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
