// The vertices of a mesh in other places than the file has them.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/scene_edits.h"

namespace fire3dv::scene {

// Whether a node's vertices can be replaced: nothing else moves them.
bool takes_vertices(const Node& node);

// As the file counts them, of all primitives that are drawn: the loader doubles some.
uint64_t file_vertex_count(const Scene& scene, const Mesh& mesh);

// Of the scene's vertices, primitive by primitive.
struct PosedVertices {
  std::vector<glm::vec3> positions, normals;
  glm::vec4 sphere{0};  // around all of them: middle and radius
};
// replaced: of as many vertices as file_vertex_count() says.
PosedVertices pose_vertices(const Scene& scene, const Mesh& mesh, const ReplacedVertices& replaced);
// As the file has them.
PosedVertices rest_vertices(const Scene& scene, const Mesh& mesh);

}  // namespace fire3dv::scene
