// Morph targets and their weights at rest.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf_accessors.h"

namespace fire3dv::scene {

struct MorphAccessors {  // of one target; -1: none
  int position = -1, normal = -1, tangent = -1;
  auto operator<=>(const MorphAccessors&) const = default;
};
std::vector<MorphAccessors> morph_accessors(const tinygltf::Primitive& primitive, const std::string& where,
                                            std::vector<std::string>& warnings);

// All primitives of a mesh have as many.
Result<uint32_t> morph_target_count(const tinygltf::Mesh& mesh, const std::string& where);

// The vertices that targets move, as the scene has them.
struct MorphBase {
  size_t source_count = 0;           // elements of an accessor
  std::span<const uint32_t> source;  // the accessors' element of each vertex; empty: in their order
  std::span<const glm::vec3> positions;
  std::span<const VertexAttributes> attributes;
  std::span<const uint32_t>
      flat;  // triangles, where normals were missing and are their triangles'; else empty
};
struct MorphRange {
  uint32_t first = kNone, count = 0;
};
Result<MorphRange> add_morphs(const AccessorReader& reader, std::span<const MorphAccessors> targets,
                              const MorphBase& base, const std::string& where, Scene& scene);

// The node's own weights, or else its mesh's, or else 0.
Result<void> add_morph_weights(const GltfDocument& document, const tinygltf::Node& source,
                               const std::string& where, Node& node, Scene& scene);

}  // namespace fire3dv::scene
