#include "renderer/scene/gltf/meshes/gltf_skins.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

namespace fire3dv::scene {
namespace {

// Limit per file: skins may share an accessor, so that a small file could claim any amount of memory.
constexpr size_t kMaxJoints = size_t{1} << 22;
constexpr float kMaxJointIndices = 65536;

int attribute(const tinygltf::Primitive& primitive, const std::string& name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

Result<std::vector<float>> read_vec4s(const AccessorReader& reader, int accessor, size_t count,
                                      const std::string& where) {
  auto own_count = reader.count(accessor, where);
  if (!own_count) return own_count.error();
  if (*own_count != count) {
    return Error{where + " has " + std::to_string(*own_count) + " elements, but POSITION has " +
                 std::to_string(count)};
  }
  std::vector<float> values(count * 4);
  if (auto done = reader.read_floats(accessor, where, values.data(), 4, 4, 4); !done) return done.error();
  return values;
}

// Normalises weights to a sum of 1, since files quantise them. A vertex without weights follows its first
// joint.
void normalize(std::span<Influences> sets) {
  double sum = 0;
  for (const Influences& set : sets) {
    for (const float weight : set.weights) sum += std::max(weight, 0.0f);
  }
  if (!(sum > 0)) {
    const uint16_t first = sets[0].joints[0];
    std::fill(sets.begin(), sets.end(), Influences{});
    sets[0].joints[0] = first;
    sets[0].weights[0] = 1;
    return;
  }
  for (Influences& set : sets) {
    for (size_t i = 0; i < 4; ++i) {
      set.weights[i] = static_cast<float>(std::max(set.weights[i], 0.0f) / sum);
      if (set.weights[i] == 0) set.joints[i] = 0;
    }
  }
}

Result<std::vector<glm::mat4>> inverse_bind_matrices(const AccessorReader& reader, const SkinSource& source,
                                                     size_t& total, const std::string& where) {
  std::vector<glm::mat4> matrices(source.joints.size(), glm::mat4(1));
  if (source.inverse_bind_matrices < 0) return matrices;
  const std::string name = where + ".inverseBindMatrices";
  auto count = reader.count(source.inverse_bind_matrices, name);
  if (!count) return count.error();
  if (*count < matrices.size()) {
    return Error{name + " holds " + std::to_string(*count) + " matrices for " +
                 std::to_string(matrices.size()) + " joints"};
  }
  total += *count;
  if (total > kMaxJoints)
    return Error{name + ": the file holds more than " + std::to_string(kMaxJoints) + " joints"};
  matrices.resize(*count);
  auto done = reader.read_floats(source.inverse_bind_matrices, name, glm::value_ptr(matrices[0]), 16, 16, 16);
  if (!done) return done.error();
  matrices.resize(source.joints.size());
  for (size_t i = 0; i < matrices.size(); ++i) {
    glm::mat4& matrix = matrices[i];
    const glm::vec4 last_row(matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]);
    // Exporters invert in float: rounding errors are tolerated.
    const glm::vec4 off = glm::abs(last_row - glm::vec4(0, 0, 0, 1));
    if (std::max({off.x, off.y, off.z, off.w}) > 1e-3f)
      return Error{name + ": matrix " + std::to_string(i) + " is not affine: its last row is not 0 0 0 1"};
    for (int column = 0; column < 4; ++column) matrix[column][3] = column == 3 ? 1.0f : 0.0f;
  }
  return matrices;
}

Result<void> add_skin(const AccessorReader& reader, const SkinSource& source, const std::string& where,
                      std::span<const uint32_t> node_of_source, size_t& total, Scene& scene) {
  if (source.joints.empty()) return Error{where + " has no joints"};
  bool shown = true;
  for (const int joint : source.joints) {
    if (!in_range(joint, node_of_source.size()))
      return out_of_range(where + ".joints", "nodes", joint, node_of_source.size());
    shown &= node_of_source[static_cast<size_t>(joint)] != kNone;
  }
  auto matrices = inverse_bind_matrices(reader, source, total, where);
  if (!matrices) return matrices.error();
  Skin skin;
  skin.name = source.name;
  skin.first_joint = static_cast<uint32_t>(scene.joints.size());
  if (shown) {
    skin.joint_count = static_cast<uint32_t>(source.joints.size());
    for (size_t i = 0; i < matrices->size(); ++i)
      scene.joints.push_back({node_of_source[static_cast<size_t>(source.joints[i])], (*matrices)[i]});
  }
  scene.skins.push_back(std::move(skin));
  return {};
}

// Joint limit of each mesh: all joint indices of its influences are below; 0: no influences.
std::vector<uint32_t> joint_limits(const Scene& scene) {
  std::vector<uint32_t> limits;
  for (const Mesh& mesh : scene.meshes) {
    uint32_t limit = 0;
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p)
      limit = std::max(limit, scene.primitives[p].joint_limit);
    limits.push_back(limit);
  }
  return limits;
}

}  // namespace

Result<InfluenceAccessors> influence_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                               std::vector<std::string>& warnings) {
  InfluenceAccessors accessors;
  for (size_t set = 0; set < 2; ++set) {
    const std::string joints = "JOINTS_" + std::to_string(set), weights = "WEIGHTS_" + std::to_string(set);
    accessors.joints[set] = attribute(primitive, joints);
    accessors.weights[set] = attribute(primitive, weights);
    const bool has_joints = accessors.joints[set] >= 0, has_weights = accessors.weights[set] >= 0;
    if (has_joints != has_weights)
      return Error{where + " has " + (has_joints ? joints : weights) + ", but no " +
                   (has_joints ? weights : joints)};
  }
  if (accessors.joints[0] < 0 && accessors.joints[1] >= 0)
    return Error{where + " has JOINTS_1, but no JOINTS_0"};
  if (attribute(primitive, "JOINTS_2") >= 0)
    warnings.push_back(where + " has more than 8 joints a vertex: JOINTS_2 and later sets are ignored");
  return accessors;
}

Result<InfluenceRange> add_influences(const AccessorReader& reader, const InfluenceAccessors& accessors,
                                      size_t count, std::span<const uint32_t> source,
                                      const std::string& where, Scene& scene) {
  InfluenceRange range;
  if (accessors.joints[0] < 0) return range;
  range.sets = accessors.joints[1] < 0 ? 1 : 2;
  range.first = static_cast<uint32_t>(scene.influences.size());
  const size_t vertices = source.empty() ? count : source.size();
  if (auto room = reader.reserve(sizeof(Influences) * uint64_t{vertices} * range.sets, where); !room)
    return room.error();
  scene.influences.resize(scene.influences.size() + vertices * range.sets);
  const std::span<Influences> made = std::span(scene.influences).subspan(range.first);
  for (uint32_t set = 0; set < range.sets; ++set) {
    const std::string name = where + ".JOINTS_" + std::to_string(set);
    auto joints = read_vec4s(reader, accessors.joints[set], count, name);
    if (!joints) return joints.error();
    auto weights =
        read_vec4s(reader, accessors.weights[set], count, where + ".WEIGHTS_" + std::to_string(set));
    if (!weights) return weights.error();
    for (const float joint : *joints) {
      if (!(joint >= 0 && joint < kMaxJointIndices) || joint != std::floor(joint))
        return Error{name + " holds " + std::to_string(joint) + ", which is not the index of a joint"};
    }
    for (size_t vertex = 0; vertex < vertices; ++vertex) {
      const size_t from = source.empty() ? vertex : source[vertex];
      Influences& influences = made[vertex * range.sets + set];
      for (size_t i = 0; i < 4; ++i) {
        influences.joints[i] = static_cast<uint16_t>((*joints)[from * 4 + i]);
        influences.weights[i] = (*weights)[from * 4 + i];
      }
    }
  }
  for (size_t vertex = 0; vertex < vertices; ++vertex) {
    const std::span<Influences> sets = made.subspan(vertex * range.sets, range.sets);
    normalize(sets);
    for (const Influences& set : sets) {
      for (const uint16_t joint : set.joints) range.joint_limit = std::max(range.joint_limit, joint + 1u);
    }
  }
  return range;
}

Result<void> add_skins(const GltfDocument& document, const LoadLimits& limits,
                       std::span<const uint32_t> node_of_source, Scene& scene) {
  const AccessorReader reader(document, limits);
  size_t matrices = 0;
  for (size_t i = 0; i < document.skins.size(); ++i) {
    auto done = add_skin(reader, document.skins[i], element("skins", i), node_of_source, matrices, scene);
    if (!done) return done;
  }
  const std::vector<uint32_t> limit_of_mesh = joint_limits(scene);
  const auto& sources = document.model.nodes;
  for (size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].skin < 0) continue;
    const std::string where = element("nodes", i);
    if (!in_range(sources[i].skin, scene.skins.size()))
      return out_of_range(where, "skins", sources[i].skin, scene.skins.size());
    if (node_of_source[i] == kNone) continue;
    Node& node = scene.nodes[node_of_source[i]];
    const auto skin = static_cast<uint32_t>(sources[i].skin);
    const uint32_t joint_count = scene.skins[skin].joint_count;
    if (node.mesh == kNone) {
      scene.warnings.push_back(where + " has a skin, but no mesh");
    } else if (limit_of_mesh[node.mesh] == 0) {
      scene.warnings.push_back(where + " has a skin, but its mesh has no JOINTS_0: it is not deformed");
    } else if (joint_count == 0) {
      scene.warnings.push_back(
          where + ": its skin has joints that are not part of the shown scene: it is not deformed");
    } else if (limit_of_mesh[node.mesh] > joint_count) {
      return Error{where + ": its mesh refers to joint " + std::to_string(limit_of_mesh[node.mesh] - 1) +
                   ", but " + element("skins", skin) + " has " + std::to_string(joint_count) + " joints"};
    } else {
      node.skin = skin;
    }
  }
  return {};
}

}  // namespace fire3dv::scene
