#include "renderer/scene/meshlets.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::scene {

// Favours clusters that face one way: whole ones are culled when they face away.
constexpr float kConeWeight = 0.25f;

void Meshlets::cut(std::span<const uint32_t> indices, const glm::vec3* positions, size_t vertex_count) {
  count = 0;
  if (indices.empty()) return;  // the library takes it for a mistake of ours
  const size_t most = meshopt_buildMeshletsBound(indices.size(), kClusterVertices, kClusterTriangles);
  meshlets.resize(most);
  vertices.resize(most * kClusterVertices);
  triangles.resize(most * kClusterTriangles * 3);
  count = meshopt_buildMeshlets(meshlets.data(), vertices.data(), triangles.data(), indices.data(),
                                indices.size(), &positions->x, vertex_count, sizeof(glm::vec3),
                                kClusterVertices, kClusterTriangles, kConeWeight);
}

Cluster Meshlets::bounded(size_t index, const glm::vec3* positions, size_t vertex_count) const {
  const meshopt_Meshlet& meshlet = meshlets[index];
  const meshopt_Bounds bounds =
      meshopt_computeMeshletBounds(&vertices[meshlet.vertex_offset], &triangles[meshlet.triangle_offset],
                                   meshlet.triangle_count, &positions->x, vertex_count, sizeof(glm::vec3));
  Cluster cluster;
  cluster.center = {bounds.center[0], bounds.center[1], bounds.center[2]};
  // The library leaves out degenerate triangles; the sphere has to hold what is drawn, whatever it is.
  float radius2 = 0;
  for (uint32_t v = 0; v < meshlet.vertex_count; ++v) {
    const glm::vec3 offset = positions[vertices[meshlet.vertex_offset + v]] - cluster.center;
    radius2 = std::max(radius2, glm::dot(offset, offset));
  }
  cluster.radius = std::sqrt(radius2) * 1.00001f;
  cluster.cone_axis = {bounds.cone_axis[0], bounds.cone_axis[1], bounds.cone_axis[2]};
  // A little beyond the library's own bound, so that rounding never culls what would be drawn.
  cluster.cone_cutoff = std::min(bounds.cone_cutoff + 1e-3f, 1.0f);
  cluster.vertex_count = meshlet.vertex_count;
  cluster.triangle_count = meshlet.triangle_count;
  return cluster;
}

}  // namespace fire3dv::scene
