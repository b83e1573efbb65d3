#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "renderer/scene/gltf/gltf_parts.h"

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
                                                     size_t& total, const std::string& where,
                                                     std::vector<std::string>& warnings) {
  const auto add_joints = [&](size_t count, const std::string& name) -> Result<void> {
    total += count;
    if (total <= kMaxJoints) return {};
    return Error{name + ": the file holds more than " + std::to_string(kMaxJoints) + " joints"};
  };
  const std::string name = where + ".inverseBindMatrices";
  const bool has_matrices = source.inverse_bind_matrices >= 0;
  if (has_matrices && !reader.has_data(source.inverse_bind_matrices))
    warnings.push_back(name + " has no data: the identity is taken");
  if (!has_matrices || !reader.has_data(source.inverse_bind_matrices)) {
    if (auto room = add_joints(source.joints.size(), where); !room) return room.error();
    return std::vector<glm::mat4>(source.joints.size(), glm::mat4(1));
  }
  auto count = reader.count(source.inverse_bind_matrices, name);
  if (!count) return count.error();
  if (*count < source.joints.size()) {
    return Error{name + " holds " + std::to_string(*count) + " matrices for " +
                 std::to_string(source.joints.size()) + " joints"};
  }
  if (auto room = add_joints(*count, name); !room) return room.error();
  std::vector<glm::mat4> matrices(*count);
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
  auto matrices = inverse_bind_matrices(reader, source, total, where, scene.warnings);
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
    const bool is_hidden = node.mesh == kNone && sources[i].mesh >= 0 &&
                           !sources[i].extensions.contains("EXT_mesh_gpu_instancing");
    if (is_hidden) {  // by KHR_node_visibility
      continue;
    } else if (node.mesh == kNone) {
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

namespace {

// Limits per file: accessors may share bytes, so that a small file could claim any amount of memory.
constexpr size_t kMaxDeltas = size_t{1} << 27;
constexpr size_t kMaxWeights = size_t{1} << 24;
constexpr size_t kDeltaFloats = sizeof(MorphDelta) / sizeof(float);
static_assert(sizeof(MorphDelta) == 9 * sizeof(float));

Result<void> read_target(const AccessorReader& reader, const MorphAccessors& target,
                         std::span<MorphDelta> deltas, const std::string& where) {
  struct Part {
    const char* name;
    int accessor;
    float* first;
  };
  for (const Part& part : {Part{".POSITION", target.position, &deltas[0].position.x},
                           Part{".NORMAL", target.normal, &deltas[0].normal.x},
                           Part{".TANGENT", target.tangent, &deltas[0].tangent.x}}) {
    if (part.accessor < 0) continue;
    const std::string name = where + part.name;
    auto count = reader.count(part.accessor, name);
    if (!count) return count.error();
    if (*count != deltas.size()) {
      return Error{name + " has " + std::to_string(*count) + " elements, but the primitive's POSITION has " +
                   std::to_string(deltas.size())};
    }
    auto done = reader.read_floats(part.accessor, name, part.first, kDeltaFloats, 3, 3);
    if (!done) return done;
  }
  return {};
}

// glTF: without normals, flat normals are computed for each target. Blending targets then blends these
// normals.
void flat_normal_deltas(const MorphBase& base, std::span<MorphDelta> deltas) {
  for (MorphDelta& delta : deltas) delta.normal = glm::vec3(0);
  for (size_t i = 0; i + 2 < base.flat.size(); i += 3) {
    const auto moved = [&](size_t corner) {
      const uint32_t vertex = base.flat[i + corner];
      return base.positions[vertex] + deltas[vertex].position;
    };
    const glm::vec3 cross = glm::cross(moved(1) - moved(0), moved(2) - moved(0));
    const float length = std::sqrt(glm::dot(cross, cross));
    if (!(length > 0 && std::isfinite(length))) continue;  // degenerate triangle: no delta
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t vertex = base.flat[i + corner];
      deltas[vertex].normal = cross / length - base.attributes[vertex].normal;
    }
  }
}

}  // namespace

std::vector<MorphAccessors> morph_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                            std::vector<std::string>& warnings) {
  std::vector<MorphAccessors> targets;
  bool others = false;
  for (const auto& source : primitive.targets) {
    MorphAccessors target;
    for (const auto& [name, accessor] : source) {
      if (name == "POSITION") {
        target.position = accessor;
      } else if (name == "NORMAL") {
        target.normal = accessor;
      } else if (name == "TANGENT") {
        target.tangent = accessor;
      } else {
        others = true;
      }
    }
    targets.push_back(target);
  }
  if (others) warnings.push_back(where + ": its morph targets change positions, normals and tangents alone");
  return targets;
}

Result<uint32_t> morph_target_count(const tinygltf::Mesh& mesh, const std::string& where) {
  const size_t count = mesh.primitives.empty() ? 0 : mesh.primitives[0].targets.size();
  for (size_t i = 1; i < mesh.primitives.size(); ++i) {
    if (mesh.primitives[i].targets.size() == count) continue;
    return Error{where + "." + element("primitives", i) + " has " +
                 std::to_string(mesh.primitives[i].targets.size()) +
                 " morph targets, but the first primitive has " + std::to_string(count)};
  }
  return static_cast<uint32_t>(count);
}

Result<MorphRange> add_morphs(const AccessorReader& reader, std::span<const MorphAccessors> targets,
                              const MorphBase& base, const std::string& where, Scene& scene) {
  MorphRange range;
  if (targets.empty()) return range;
  const size_t vertices = base.positions.size();
  const size_t first = scene.morph_deltas.size();
  if (targets.size() > (kMaxDeltas - first) / vertices) {
    return Error{where + ": the morph targets of the file hold more than " + std::to_string(kMaxDeltas) +
                 " vertices; split it"};
  }
  range.first = static_cast<uint32_t>(first);
  range.count = static_cast<uint32_t>(targets.size());
  if (auto room = reader.reserve(sizeof(MorphDelta) * uint64_t{targets.size()} * vertices, where); !room)
    return room.error();
  scene.morph_deltas.resize(first + targets.size() * vertices);
  std::vector<MorphDelta> in_file_order(base.source.empty() ? 0 : base.source_count);
  for (size_t t = 0; t < targets.size(); ++t) {
    const std::span<MorphDelta> deltas =
        std::span(scene.morph_deltas).subspan(first + t * vertices, vertices);
    const std::string name = where + "." + element("targets", t);
    if (base.source.empty()) {
      if (auto done = read_target(reader, targets[t], deltas, name); !done) return done.error();
    } else {
      in_file_order.assign(base.source_count, MorphDelta{});
      if (auto done = read_target(reader, targets[t], in_file_order, name); !done) return done.error();
      for (size_t vertex = 0; vertex < vertices; ++vertex)
        deltas[vertex] = in_file_order[base.source[vertex]];
    }
    if (!base.flat.empty()) flat_normal_deltas(base, deltas);
  }
  return range;
}

Result<void> add_morph_weights(const GltfDocument& document, const tinygltf::Node& source,
                               const std::string& where, Node& node, Scene& scene) {
  if (node.mesh == kNone) return {};
  const uint32_t count = scene.meshes[node.mesh].morph_target_count;
  const std::vector<double>& of_mesh = document.model.meshes[node.mesh].weights;
  const std::vector<double>& weights = source.weights.empty() ? of_mesh : source.weights;
  if (!weights.empty() && weights.size() != count) {
    return Error{(source.weights.empty() ? element("meshes", node.mesh) : where) + ".weights holds " +
                 std::to_string(weights.size()) + " numbers for " + std::to_string(count) + " morph targets"};
  }
  if (scene.morph_weights.size() + count > kMaxWeights)
    return Error{where + ": the file has more than " + std::to_string(kMaxWeights) + " morph weights"};
  node.first_morph_weight = static_cast<uint32_t>(scene.morph_weights.size());
  node.morph_weight_count = count;
  for (uint32_t i = 0; i < count; ++i)
    scene.morph_weights.push_back(weights.empty() ? 0.0f : to_float(weights[i]));
  return {};
}

}  // namespace fire3dv::scene
