#include "renderer/passes/resources/deformed_shapes.h"

#include <algorithm>
#include <map>

#include "shaders/shared/types.h"

namespace fire3dv::passes {
namespace {

constexpr uint32_t kGroupVertices = 64;  // threads of deform/deform.comp

template <typename T>
gpu::Buffer upload_array(gpu::Device& device, gpu::LoaderCommands& loader, const std::vector<T>& values) {
  gpu::Buffer buffer = gpu::create_buffer(device, values.size() * sizeof(T),
                                          VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::filled_memory(device));
  loader.upload(buffer, std::span<const T>(values));
  return buffer;
}

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

}  // namespace

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

}  // namespace fire3dv::passes
