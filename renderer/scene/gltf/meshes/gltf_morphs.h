// glTF morph target loader: vertex deltas and rest weights.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf/meshes/gltf_accessors.h"

namespace fire3dv::scene {

// Accessors of one target; -1: none.
struct MorphAccessors {
  int position = -1, normal = -1, tangent = -1;
  auto operator<=>(const MorphAccessors&) const = default;
};
std::vector<MorphAccessors> morph_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                            std::vector<std::string>& warnings);

// Fails unless all primitives of the mesh have the same number of targets.
Result<uint32_t> morph_target_count(const tinygltf::Mesh& mesh, const std::string& where);

// Base vertices of a primitive, in the scene's layout.
struct MorphBase {
  size_t source_count = 0;           // elements per accessor
  std::span<const uint32_t> source;  // accessor element of each vertex; empty: identity
  std::span<const glm::vec3> positions;
  std::span<const VertexAttributes> attributes;
  // Triangles with generated flat normals; empty if the file has normals.
  std::span<const uint32_t> flat;
};
struct MorphRange {
  uint32_t first = kNone, count = 0;
};
Result<MorphRange> add_morphs(const AccessorReader& reader, std::span<const MorphAccessors> targets,
                              const MorphBase& base, const std::string& where, Scene& scene);

// Weights of the node, else of its mesh, else 0.
Result<void> add_morph_weights(const GltfDocument& document, const tinygltf::Node& source,
                               const std::string& where, Node& node, Scene& scene);

}  // namespace fire3dv::scene
