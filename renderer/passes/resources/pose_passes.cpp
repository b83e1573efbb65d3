#include "renderer/passes/resources/pose_passes.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "renderer/passes/resources/gpu_scene.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

using gpu::Use;
namespace access = gpu::access;

gpu_types::AffineRows to_rows(const wire::Affine3x4& affine) {
  gpu_types::AffineRows rows;
  static_assert(sizeof(rows) == sizeof(affine));
  std::memcpy(&rows, affine.m.data(), sizeof(rows));
  return rows;
}

gpu_types::AffineRows to_rows(const wire::Affine3x4d& affine) {
  wire::Affine3x4 single;
  for (size_t i = 0; i < 12; ++i) single.m[i] = static_cast<float>(affine.m[i]);
  return to_rows(single);
}

constexpr uint32_t kGroupVertices = 64;  // threads of deform/deform.comp

gpu_types::AffineRows rows_of(const glm::mat4& matrix) {
  const glm::mat4 rows = glm::transpose(matrix);
  return {rows[0], rows[1], rows[2]};
}

std::vector<gpu_types::InfluenceRecord> influence_records(const scene::Scene& scene) {
  std::vector<gpu_types::InfluenceRecord> records;
  records.reserve(scene.influences.size());
  for (const scene::Influences& from : scene.influences) {
    const auto& j = from.joints;
    records.push_back({j[0] | uint32_t{j[1]} << 16,
                       j[2] | uint32_t{j[3]} << 16,
                       {from.weights[0], from.weights[1], from.weights[2], from.weights[3]}});
  }
  return records;
}

std::vector<gpu_types::JointRecord> joint_records(const scene::Scene& scene) {
  std::vector<gpu_types::JointRecord> records;
  for (const scene::Joint& joint : scene.joints)
    records.push_back({rows_of(joint.joint_from_mesh), joint.node});
  return records;
}

class Tables {
 public:
  Tables(const scene::Scene& scene, const scene::ClusteredGeometry& geometry)
      : scene_(scene), geometry_(geometry) {
    for (const scene::JointBounds& from : scene.joint_bounds) {
      bounds.push_back({from.joint, from.bounds_min, from.bounds_max});
    }
  }

  void add(const scene::Node& node, uint32_t node_index, uint32_t source, uint32_t copy) {
    const scene::Primitive& primitive = scene_.primitives[source];
    const scene::ClusteredPrimitive& posed = geometry_.primitives[copy];
    gpu_types::DeformRecord record{};
    record.node = node_index;
    record.primitive = copy;
    record.rest_vertex = geometry_.primitives[source].first_vertex;
    record.posed_vertex = posed.first_vertex;
    record.vertex_count = posed.vertex_count;
    record.first_source = first_source(source);
    record.skinned = node.skin != scene::kNone ? 1 : 0;
    record.sign_x = scene::is_mirrored_by_joints(scene_, node) ? -1.0f : 1.0f;
    record.first_influence = FIRE3DV_NO_INDEX;
    if (record.skinned != 0) {
      if (primitive.first_influence != scene::kNone) {
        record.first_influence = primitive.first_influence;
        record.influence_sets = primitive.influence_sets;
        record.first_bounds = primitive.first_joint_bounds;
        record.bounds_count = primitive.joint_bounds_count;
      } else {
        record.first_bounds = static_cast<uint32_t>(bounds.size());
        record.bounds_count = 1;
        bounds.push_back({FIRE3DV_NO_INDEX, primitive.bounds_min, primitive.bounds_max});
      }
      record.first_joint = scene_.skins[node.skin].first_joint;
    }
    record.target_count = std::min(primitive.morph_target_count, node.morph_weight_count);
    if (record.target_count != 0) record.first_delta = primitive.first_morph_delta;
    record.delta_stride = primitive.vertex_count;
    record.first_weight = node.first_morph_weight;
    for (uint32_t v = 0; v < record.vertex_count; v += kGroupVertices) {
      groups.push_back({static_cast<uint32_t>(records.size()), v});
    }
    records.push_back(record);
  }

  std::vector<gpu_types::DeformRecord> records;
  std::vector<gpu_types::DeformGroup> groups;
  std::vector<uint32_t> sources;
  std::vector<gpu_types::JointBoundsRecord> bounds;

 private:
  uint32_t first_source(uint32_t source) {
    const auto [known, is_new] = first_source_.try_emplace(source, static_cast<uint32_t>(sources.size()));
    if (is_new) {
      const scene::ClusteredPrimitive& rest = geometry_.primitives[source];
      for (uint32_t v = 0; v < rest.vertex_count; ++v) {
        sources.push_back(geometry_.source_vertices[rest.first_vertex + v] -
                          scene_.primitives[source].first_vertex);
      }
    }
    return known->second;
  }

  const scene::Scene& scene_;
  const scene::ClusteredGeometry& geometry_;
  std::map<uint32_t, uint32_t> first_source_;  // of the scene's primitives
};

// Rows of 65535 groups, the guaranteed minimum of all devices.
void dispatch(VkCommandBuffer commands, uint32_t groups) {
  if (groups) vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, 1);
}

}  // namespace

TransformsPass::TransformsPass(gpu::Device& device, VkPipelineLayout layout)
    : device_(device),
      layout_(layout),
      pipeline_(gpu::create_compute_pipeline(device, layout, "transforms.comp")) {}

void TransformsPass::invalidate() {
  uploaded_drives_ = UINT64_MAX;
  streams_.clear();
}

void TransformsPass::upload_drives(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                   const state::PoseState& poses) {
  if (uploaded_drives_ == poses.drive_revision()) return;
  std::vector<gpu_types::NodeSource> sources;
  sources.reserve(poses.node_drives().size());
  for (const state::NodeDrive& drive : poses.node_drives()) {
    sources.push_back({to_rows(drive.body_from_node), drive.stream, drive.pose_index});
  }
  const VkDeviceSize bytes = sources.size() * sizeof(gpu_types::NodeSource);
  if (!sources_ || sources_.size_bytes < bytes) {
    sources_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
  }
  const gpu::StagingRing::Piece piece = staging.write(std::span<const gpu_types::NodeSource>(sources));
  recorder.pass("pose sources", {Use(sources_, access::transfer_write)}, [&](VkCommandBuffer commands) {
    const VkBufferCopy copy{piece.offset, 0, bytes};
    if (bytes) vkCmdCopyBuffer(commands, piece.buffer, sources_.get(), 1, &copy);
  });
  uploaded_drives_ = poses.drive_revision();
}

void TransformsPass::upload_poses(gpu::Recorder& recorder, gpu::StagingRing& staging,
                                  const state::PoseState& poses) {
  const std::vector<state::Stream>& streams = poses.streams();
  streams_.resize(streams.size());
  struct Copy {
    VkBuffer from, to;
    VkBufferCopy region;
  };
  std::vector<Copy> copies;
  std::vector<Use> uses;
  for (size_t s = 0; s < streams.size(); ++s) {
    StreamPoses& uploaded = streams_[s];
    const state::Stream& stream = streams[s];
    if (stream.poses.empty() || (uploaded.epoch == stream.epoch && uploaded.revision == stream.revision))
      continue;
    const VkDeviceSize bytes = stream.poses.size() * sizeof(wire::Affine3x4);
    if (!uploaded.poses || uploaded.poses.size_bytes < bytes) {
      uploaded.poses =
          gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
    }
    const gpu::StagingRing::Piece piece = staging.write(std::span<const wire::Affine3x4>(stream.poses));
    copies.push_back({piece.buffer, uploaded.poses.get(), {piece.offset, 0, bytes}});
    uses.emplace_back(uploaded.poses, access::transfer_write);
    uploaded.epoch = stream.epoch;
    uploaded.revision = stream.revision;
  }
  if (copies.empty()) return;
  recorder.pass("poses", uses,
                [&](VkCommandBuffer commands) {  // one pass for all streams, since timestamp queries are
                                                 // limited
                  for (const Copy& copy : copies)
                    vkCmdCopyBuffer(commands, copy.from, copy.to, 1, &copy.region);
                });
}

void TransformsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                            const state::PoseState& poses) {
  upload_drives(recorder, staging, poses);
  upload_poses(recorder, staging, poses);
  if (scene.node_count == 0) return;

  std::vector<gpu_types::StreamSource> stream_sources;
  std::vector<Use> uses{Use(sources_, access::compute_read),
                        Use(scene.world_from_node, access::compute_write)};
  for (size_t s = 0; s < streams_.size(); ++s) {
    stream_sources.push_back({streams_[s].poses.address, to_rows(poses.streams()[s].world_from_stream)});
    if (streams_[s].poses) uses.emplace_back(streams_[s].poses, access::compute_read);
  }
  if (scene.instances) uses.emplace_back(scene.instances, access::compute_write);

  gpu_types::TransformsPush push{};
  push.sources = sources_.address;
  push.streams = staging.write(std::span<const gpu_types::StreamSource>(stream_sources)).address;
  push.world_from_node = scene.world_from_node.address;
  push.instance_of_node = scene.instance_of_node.address;
  push.instances = scene.instances.address;
  push.node_facts = scene.node_facts();
  push.light_of_node = scene.light_of_node.address;
  push.lights = scene.lights.address;
  push.light_poses = scene.light_poses();
  push.node_count = scene.node_count;
  recorder.pass("transforms", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (scene.node_count + 63) / 64, 1, 1);
  });
}

DeformedShapes::DeformedShapes(gpu::Device& device, gpu::LoaderCommands& loader, const scene::Scene& scene,
                               std::vector<scene::DeformedNode> deformed,
                               const scene::ClusteredGeometry& geometry)
    : nodes(std::move(deformed)) {
  if (nodes.empty()) return;
  Tables tables(scene, geometry);
  for (const scene::DeformedNode& shape : nodes) {
    const scene::Node& node = scene.nodes[shape.node];
    if (node.has_instance_vertices) continue;  // written when the edit replaces them
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t i = 0; i < mesh.primitive_count; ++i) {
      tables.add(node, shape.node, mesh.first_primitive + i, shape.first_primitive + i);
    }
  }
  record_count = static_cast<uint32_t>(tables.records.size());
  group_count = static_cast<uint32_t>(tables.groups.size());
  records = upload_array(device, loader, tables.records);
  groups = upload_array(device, loader, tables.groups);
  sources = upload_array(device, loader, tables.sources);
  joint_bounds = upload_array(device, loader, tables.bounds);
  influences = upload_array(device, loader, influence_records(scene));
  joints = upload_array(device, loader, joint_records(scene));
  static_assert(sizeof(scene::MorphDelta) == sizeof(gpu_types::MorphDeltaRecord));
  deltas = upload_array(device, loader, scene.morph_deltas);
  weights = upload_array(device, loader, scene.morph_weights);
}

DeformPass::DeformPass(gpu::Device& device, VkPipelineLayout layout)
    : layout_(layout),
      deform_(gpu::create_compute_pipeline(device, layout, "deform.comp", gpu::Compile::on_first_use)),
      bounds_(
          gpu::create_compute_pipeline(device, layout, "deform_bounds.comp", gpu::Compile::on_first_use)) {}

void DeformPass::upload_weights(gpu::Recorder& recorder, gpu::StagingRing& staging, DeformedShapes& shapes,
                                const state::PoseState& poses) {
  if (weights_revision_ == poses.drive_revision()) return;
  weights_revision_ = poses.drive_revision();
  const std::vector<float>& weights = poses.morph_weights();
  if (weights.empty()) return;
  const gpu::StagingRing::Piece piece = staging.write(std::span<const float>(weights));
  recorder.pass("morph weights", {Use(shapes.weights, access::transfer_write)},
                [&](VkCommandBuffer commands) {
                  const VkBufferCopy copy{piece.offset, 0, weights.size() * sizeof(float)};
                  vkCmdCopyBuffer(commands, piece.buffer, shapes.weights.get(), 1, &copy);
                });
}

void DeformPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                        const state::PoseState& poses) {
  DeformedShapes& shapes = scene.deformed;
  if (shapes.record_count == 0 || poses_revision_ == poses.revision()) return;
  poses_revision_ = poses.revision();
  upload_weights(recorder, staging, shapes, poses);

  gpu_types::DeformPush push{};
  push.records = shapes.records.address;
  push.groups = shapes.groups.address;
  push.sources = shapes.sources.address;
  push.influences = shapes.influences.address;
  push.joints = shapes.joints.address;
  push.joint_bounds = shapes.joint_bounds.address;
  push.deltas = shapes.deltas.address;
  push.weights = shapes.weights.address;
  push.world_from_node = scene.world_from_node.address;
  push.positions = scene.positions.address;
  push.frames = scene.frames.address;
  push.tangents = scene.tangents.address;
  push.primitives = scene.primitives.address;
  std::vector<Use> uses{Use(shapes.weights, access::compute_read),
                        Use(scene.world_from_node, access::compute_read),
                        Use(scene.positions, access::compute_write), Use(scene.frames, access::compute_write),
                        Use(scene.primitives, access::compute_write)};
  if (scene.tangents) uses.emplace_back(scene.tangents, access::compute_write);
  recorder.pass("deform", uses, [&](VkCommandBuffer commands) {
    push.group_count = shapes.group_count;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, deform_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    dispatch(commands, shapes.group_count);
    push.group_count = shapes.record_count;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, bounds_.get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    dispatch(commands, shapes.record_count);
  });
  levels_outdated_ = true;
}

void DeformPass::record_levels(gpu::Recorder& recorder, GpuScene& scene) {
  DeformedShapes& shapes = scene.deformed;
  if (shapes.levels.empty() || !levels_outdated_) return;
  levels_outdated_ = false;
  // Rays of the last frame read these through the top-level structure, which therefore stands in for them
  // here.
  recorder.pass(
      "deformed blas",
      {Use(scene.positions, access::build_input), Use(scene.indices, access::build_input),
       Use(shapes.levels.scratch(), access::build_write), Use(shapes.levels.storage(), access::build_write),
       Use(scene.top_level.storage(), access::build_write)},
      [&](VkCommandBuffer commands) { shapes.levels.record(commands); });
}

}  // namespace fire3dv::passes
