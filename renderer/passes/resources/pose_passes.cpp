#include "renderer/passes/resources/pose_passes.h"

#include <algorithm>
#include <cstring>
#include <map>

#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/passes/resources/shader_variant.h"
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

struct BufferCopy {
  VkBuffer from, to;
  VkBufferCopy region;
};

void add_copy(std::vector<BufferCopy>& copies, std::vector<Use>& uses, const gpu::StagingRing::Piece& from,
              gpu::Buffer& to, VkDeviceSize bytes) {
  copies.push_back({from.buffer, to.get(), {from.offset, 0, bytes}});
  uses.emplace_back(to, access::transfer_write);
}

// One pass for all copies, since timestamp queries are limited.
void record_copies(gpu::Recorder& recorder, const char* name, const std::vector<Use>& uses,
                   const std::vector<BufferCopy>& copies) {
  if (copies.empty()) return;
  recorder.pass(name, uses, [&](VkCommandBuffer commands) {
    for (const BufferCopy& copy : copies) {
      if (copy.region.size) vkCmdCopyBuffer(commands, copy.from, copy.to, 1, &copy.region);
    }
  });
}

// Adds a copy to those of one upload; it may continue the last one.
void add_region(std::vector<VkBufferCopy>& regions, const VkBufferCopy& region) {
  if (region.size == 0) return;
  if (!regions.empty()) {
    VkBufferCopy& last = regions.back();
    if (last.srcOffset + last.size == region.srcOffset && last.dstOffset + last.size == region.dstOffset) {
      last.size += region.size;
      return;
    }
  }
  regions.push_back(region);
}

// Records the copies of a staging piece, at offsets within it.
void record_upload(gpu::Recorder& recorder, const char* name, gpu::Buffer& to,
                   const gpu::StagingRing::Piece& piece, std::vector<VkBufferCopy>&& regions) {
  if (regions.empty()) return;
  for (VkBufferCopy& region : regions) region.srcOffset += piece.offset;
  recorder.pass(name, {Use(to, access::transfer_write)}, [&](VkCommandBuffer commands) {
    vkCmdCopyBuffer(commands, piece.buffer, to.get(), static_cast<uint32_t>(regions.size()), regions.data());
  });
}

// Rows of 65535 groups, the guaranteed minimum of all devices.
void dispatch(VkCommandBuffer commands, uint32_t groups) {
  if (groups) vkCmdDispatch(commands, std::min(groups, 65535u), (groups + 65534) / 65535, 1);
}

}  // namespace

TransformsPass::TransformsPass(gpu::Device& device, VkPipelineLayout layout)
    : device_(device), layout_(layout) {
  pipelines_[0] = gpu::create_compute_pipeline(device, layout, "transforms.comp");
}

void TransformsPass::expect_worlds() {
  if (pipelines_[1]) return;
  ShaderVariant variant;
  variant.several_worlds = true;
  pipelines_[1] = gpu::create_compute_pipeline(device_, layout_, "transforms.comp", gpu::Compile::next,
                                               variant.constants());
}

void TransformsPass::upload_drives(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses) {
  VkDeviceSize stride = source_bytes_;
  bool has_changed = false;
  for (size_t w = 0; w < poses.size(); ++w) {
    has_changed |= worlds_[w].drives != poses[w]->drive_revision();
    stride = std::max(stride, poses[w]->node_drives().size() * sizeof(gpu_types::NodeSource));
  }
  if (!has_changed) return;
  if (stride > source_bytes_ || sources_.size_bytes < stride * poses.size()) {
    sources_ = gpu::create_buffer(device_, stride * poses.size(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                  gpu::Memory::device);
    source_bytes_ = stride;
    for (World& world : worlds_) world.drives = UINT64_MAX;
  }
  std::vector<gpu_types::NodeSource> sources;  // of the changed worlds
  std::vector<VkBufferCopy> regions;
  for (size_t w = 0; w < poses.size(); ++w) {
    if (worlds_[w].drives == poses[w]->drive_revision()) continue;
    worlds_[w].drives = poses[w]->drive_revision();
    const VkDeviceSize from = sources.size() * sizeof(gpu_types::NodeSource);
    for (const state::NodeDrive& drive : poses[w]->node_drives())
      sources.push_back({to_rows(drive.body_from_node), drive.stream, drive.pose_index});
    add_region(regions, {from, w * source_bytes_, sources.size() * sizeof(gpu_types::NodeSource) - from});
  }
  record_upload(recorder, "pose sources", sources_,
                staging.write(std::span<const gpu_types::NodeSource>(sources)), std::move(regions));
}

// Lays out the poses of all worlds again when a stream has more of them than before.
void TransformsPass::make_room_for_poses(PosesOfWorlds poses) {
  bool has_room = true;
  for (size_t w = 0; w < poses.size(); ++w) {
    const std::vector<state::Stream>& streams = poses[w]->streams();
    worlds_[w].streams.resize(streams.size());
    for (size_t s = 0; s < streams.size(); ++s)
      has_room &= streams[s].poses.size() <= worlds_[w].streams[s].capacity;
  }
  if (has_room) return;
  VkDeviceSize bytes = 0;
  for (size_t w = 0; w < poses.size(); ++w) {
    for (size_t s = 0; s < worlds_[w].streams.size(); ++s) {
      StreamPoses& stream = worlds_[w].streams[s];
      stream.capacity = std::max(stream.capacity, poses[w]->streams()[s].poses.size());
      stream.offset = bytes;
      stream.revision = UINT64_MAX;
      bytes += stream.capacity * sizeof(wire::Affine3x4);
    }
  }
  poses_ = gpu::create_buffer(device_, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::Memory::device);
}

void TransformsPass::upload_poses(gpu::Recorder& recorder, gpu::StagingRing& staging, PosesOfWorlds poses) {
  make_room_for_poses(poses);
  std::vector<const std::vector<wire::Affine3x4>*> changed;
  std::vector<VkBufferCopy> regions;
  VkDeviceSize bytes = 0;
  for (size_t w = 0; w < poses.size(); ++w) {
    const std::vector<state::Stream>& streams = poses[w]->streams();
    for (size_t s = 0; s < streams.size(); ++s) {
      StreamPoses& uploaded = worlds_[w].streams[s];
      const state::Stream& stream = streams[s];
      if (stream.poses.empty() || (uploaded.epoch == stream.epoch && uploaded.revision == stream.revision))
        continue;
      changed.push_back(&stream.poses);
      const VkDeviceSize of_stream = stream.poses.size() * sizeof(wire::Affine3x4);
      add_region(regions, {bytes, uploaded.offset, of_stream});
      bytes += of_stream;
      uploaded.epoch = stream.epoch;
      uploaded.revision = stream.revision;
    }
  }
  if (changed.empty()) return;
  const gpu::StagingRing::Piece piece = staging.allocate(bytes);
  std::byte* to = piece.mapped;
  for (const std::vector<wire::Affine3x4>* of_stream : changed) {
    std::memcpy(to, of_stream->data(), of_stream->size() * sizeof(wire::Affine3x4));
    to += of_stream->size() * sizeof(wire::Affine3x4);
  }
  record_upload(recorder, "poses", poses_, piece, std::move(regions));
}

void TransformsPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                            PosesOfWorlds poses) {
  worlds_.resize(poses.size());
  upload_drives(recorder, staging, poses);
  upload_poses(recorder, staging, poses);
  if (scene.node_count == 0) return;

  std::vector<gpu_types::StreamSource> streams;  // of all worlds
  for (uint32_t w = 0; w < poses.size(); ++w) {
    for (size_t s = 0; s < worlds_[w].streams.size(); ++s) {
      const StreamPoses& stream = worlds_[w].streams[s];
      streams.push_back({stream.capacity ? poses_.address + stream.offset : 0,
                         to_rows(poses[w]->streams()[s].world_from_stream)});
    }
  }
  VkDeviceAddress of_world = staging.write(std::span<const gpu_types::StreamSource>(streams)).address;
  std::vector<gpu_types::TransformsPush> worlds;
  for (uint32_t w = 0; w < poses.size(); ++w) {
    gpu_types::TransformsPush& push = worlds.emplace_back();
    push.sources = sources_.address + w * source_bytes_;
    push.streams = of_world;
    of_world += worlds_[w].streams.size() * sizeof(gpu_types::StreamSource);
    push.world_from_node = scene.nodes_of(w);
    push.instance_of_node = scene.instance_of_node.address;
    push.instances = scene.instances_of(w);
    push.node_facts = scene.node_facts_of(w);
    push.light_of_node = scene.light_of_node.address;
    push.lights = scene.lights.address;
    push.light_poses = scene.light_poses_of(w);
    push.node_count = scene.node_count;
  }
  std::vector<Use> uses{Use(scene.world_from_node, access::compute_write),
                        Use(sources_, access::compute_read)};
  if (poses_) uses.emplace_back(poses_, access::compute_read);
  if (scene.instances) uses.emplace_back(scene.instances, access::compute_write);
  const bool common = worlds.size() > 1;
  gpu_types::TransformsPush push = worlds[0];
  if (common) {
    expect_worlds();
    push = {};
    push.sources = staging.write(std::span<const gpu_types::TransformsPush>(worlds)).address;
  }
  recorder.pass("transforms", uses, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[common ? 1 : 0].get());
    vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
    vkCmdDispatch(commands, (scene.node_count + 63) / 64, static_cast<uint32_t>(worlds.size()), 1);
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
}

DeformPass::DeformPass(gpu::Device& device, VkPipelineLayout layout)
    : layout_(layout),
      deform_(gpu::create_compute_pipeline(device, layout, "deform.comp", gpu::Compile::on_first_use)),
      bounds_(
          gpu::create_compute_pipeline(device, layout, "deform_bounds.comp", gpu::Compile::on_first_use)) {}

void DeformPass::upload_weights(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                                PosesOfWorlds poses) {
  std::vector<BufferCopy> copies;
  std::vector<Use> uses;
  for (size_t w = 0; w < poses.size(); ++w) {
    if (worlds_[w].weights == poses[w]->drive_revision()) continue;
    worlds_[w].weights = poses[w]->drive_revision();
    const std::vector<float>& weights = poses[w]->morph_weights();
    if (weights.empty()) continue;
    add_copy(copies, uses, staging.write(std::span<const float>(weights)), scene.deformed_worlds[w].weights,
             weights.size() * sizeof(float));
  }
  record_copies(recorder, "morph weights", uses, copies);
}

void DeformPass::record(gpu::Recorder& recorder, gpu::StagingRing& staging, GpuScene& scene,
                        PosesOfWorlds poses) {
  const DeformedShapes& shapes = scene.deformed;
  worlds_.resize(poses.size());
  bool has_changed = false;
  for (size_t w = 0; w < poses.size(); ++w) has_changed |= worlds_[w].poses != poses[w]->revision();
  if (shapes.record_count == 0 || !has_changed) return;
  upload_weights(recorder, staging, scene, poses);

  std::vector<gpu_types::DeformPush> pushes;
  std::vector<Use> uses{Use(scene.world_from_node, access::compute_read)};
  for (uint32_t w = 0; w < poses.size(); ++w) {
    if (worlds_[w].poses == poses[w]->revision()) continue;
    worlds_[w].poses = poses[w]->revision();
    VertexBuffers& vertices = scene.vertices_of(w);
    uses.emplace_back(scene.deformed_worlds[w].weights, access::compute_read);
    for (gpu::Buffer* written : {&vertices.positions, &vertices.frames, &vertices.primitives})
      uses.emplace_back(*written, access::compute_write);
    if (vertices.tangents) uses.emplace_back(vertices.tangents, access::compute_write);
    gpu_types::DeformPush& push = pushes.emplace_back();
    push.records = shapes.records.address;
    push.groups = shapes.groups.address;
    push.sources = shapes.sources.address;
    push.influences = shapes.influences.address;
    push.joints = shapes.joints.address;
    push.joint_bounds = shapes.joint_bounds.address;
    push.deltas = shapes.deltas.address;
    push.weights = scene.deformed_worlds[w].weights.address;
    push.world_from_node = scene.nodes_of(w);
    push.positions = vertices.positions.address;
    push.frames = vertices.frames.address;
    push.tangents = vertices.tangents.address;
    push.primitives = vertices.primitives.address;
  }
  recorder.pass("deform", uses, [&](VkCommandBuffer commands) {
    const auto run = [&](const gpu::Pipeline& pipeline, uint32_t group_count) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.get());
      for (gpu_types::DeformPush& push : pushes) {
        push.group_count = group_count;
        vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_ALL, 0, sizeof(push), &push);
        dispatch(commands, group_count);
      }
    };
    run(deform_, shapes.group_count);
    run(bounds_, shapes.record_count);
  });
  levels_outdated_ = true;
}

void DeformPass::record_levels(gpu::Recorder& recorder, GpuScene& scene) {
  if (scene.deformed_worlds.empty() || scene.deformed_worlds[0].levels.empty() || !levels_outdated_) return;
  levels_outdated_ = false;
  // Rays of the last frame read these through the top-level structures, which therefore stand in for them
  // here.
  std::vector<Use> uses{Use(scene.indices, access::build_input),
                        Use(scene.top_level.storage(), access::build_write)};
  for (uint32_t world = 0; world < scene.world_count; ++world) {
    gpu::DeformedLevels& levels = scene.deformed_worlds[world].levels;
    uses.emplace_back(scene.vertices_of(world).positions, access::build_input);
    uses.emplace_back(levels.scratch(), access::build_write);
    uses.emplace_back(levels.storage(), access::build_write);
  }
  recorder.pass("deformed blas", uses, [&](VkCommandBuffer commands) {
    for (DeformedWorld& world : scene.deformed_worlds) world.levels.record(commands);
  });
}

}  // namespace fire3dv::passes
