// Replaced vertices of a mesh: positions from a scene edit, with its normals or recomputed ones.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/edits/scene_edits.h"

namespace fire3dv::scene {

// True if the node has a mesh that neither a skin nor morph targets deform.
bool can_replace_vertices(const Node& node);

// Number of vertices of all drawn primitives in the file; the loader may have duplicated some.
uint64_t file_vertex_count(const Scene& scene, const Mesh& mesh);

// Posed scene vertices, primitive by primitive.
struct PosedVertices {
  std::vector<glm::vec3> positions, normals;
  glm::vec4 sphere{0};  // bounding sphere: centre and radius
};
// replaced: has file_vertex_count() vertices.
PosedVertices pose_vertices(const Scene& scene, const Mesh& mesh, const ReplacedVertices& replaced);
// Vertices as in the file.
PosedVertices rest_vertices(const Scene& scene, const Mesh& mesh);

}  // namespace fire3dv::scene
