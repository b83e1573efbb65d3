#include "renderer/scene/gltf/meshes/gltf_morphs.h"

#include <cmath>

namespace fire3dv::scene {
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
