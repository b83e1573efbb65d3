#include "renderer/scene/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "renderer/scene/parallel.h"

namespace fire3dv::scene {
namespace {

// Favours clusters that face one way: whole ones are culled when they face away.
constexpr float kConeWeight = 0.25f;

struct Scratch {
  std::vector<meshopt_Meshlet> meshlets;
  std::vector<unsigned int> vertices;
  std::vector<unsigned char> triangles;
};

Cluster bounded_cluster(const meshopt_Meshlet& meshlet, const Scratch& scratch, const float* positions,
                        size_t vertex_count) {
  const meshopt_Bounds bounds = meshopt_computeMeshletBounds(
      &scratch.vertices[meshlet.vertex_offset], &scratch.triangles[meshlet.triangle_offset],
      meshlet.triangle_count, positions, vertex_count, sizeof(glm::vec3));
  Cluster cluster;
  cluster.center = {bounds.center[0], bounds.center[1], bounds.center[2]};
  // The library leaves out degenerate triangles; the sphere has to hold what is drawn, whatever it is.
  float radius2 = 0;
  for (uint32_t v = 0; v < meshlet.vertex_count; ++v) {
    const float* p = positions + size_t{3} * scratch.vertices[meshlet.vertex_offset + v];
    const glm::vec3 offset = glm::vec3(p[0], p[1], p[2]) - cluster.center;
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

// What one primitive is cut into, with offsets into its own arrays.
struct Piece {
  std::vector<uint32_t> source_vertices, triangles, indices;
  std::vector<Cluster> clusters;
};

Piece cut_primitive(const Scene& scene, const Primitive& source) {
  Piece out;
  if (source.index_count == 0) return out;  // the library takes it for a mistake of ours
  const size_t most = meshopt_buildMeshletsBound(source.index_count, kClusterVertices, kClusterTriangles);
  Scratch scratch;
  scratch.meshlets.resize(most);
  scratch.vertices.resize(most * kClusterVertices);
  scratch.triangles.resize(most * kClusterTriangles * 3);
  const auto* positions = reinterpret_cast<const float*>(scene.positions.data() + source.first_vertex);
  const size_t count = meshopt_buildMeshlets(
      scratch.meshlets.data(), scratch.vertices.data(), scratch.triangles.data(),
      scene.indices.data() + source.first_index, source.index_count, positions, source.vertex_count,
      sizeof(glm::vec3), kClusterVertices, kClusterTriangles, kConeWeight);
  out.clusters.reserve(count);
  out.indices.reserve(source.index_count);
  out.triangles.reserve(source.index_count / 3);
  for (size_t m = 0; m < count; ++m) {
    const meshopt_Meshlet& meshlet = scratch.meshlets[m];
    Cluster cluster = bounded_cluster(meshlet, scratch, positions, source.vertex_count);
    cluster.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
    cluster.first_triangle = static_cast<uint32_t>(out.triangles.size());
    for (uint32_t v = 0; v < meshlet.vertex_count; ++v) {
      out.source_vertices.push_back(source.first_vertex + scratch.vertices[meshlet.vertex_offset + v]);
    }
    for (uint32_t t = 0; t < meshlet.triangle_count; ++t) {
      const unsigned char* corner = &scratch.triangles[meshlet.triangle_offset + size_t{3} * t];
      out.triangles.push_back(corner[0] | uint32_t{corner[1]} << 8 | uint32_t{corner[2]} << 16);
      for (int c = 0; c < 3; ++c) out.indices.push_back(cluster.first_vertex + corner[c]);
    }
    out.clusters.push_back(cluster);
  }
  return out;
}

template <typename T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

ClusteredPrimitive append(ClusteredGeometry& out, Piece piece) {
  ClusteredPrimitive primitive;
  primitive.first_index = static_cast<uint32_t>(out.indices.size());
  primitive.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
  primitive.first_cluster = static_cast<uint32_t>(out.clusters.size());
  primitive.index_count = static_cast<uint32_t>(piece.indices.size());
  primitive.vertex_count = static_cast<uint32_t>(piece.source_vertices.size());
  primitive.cluster_count = static_cast<uint32_t>(piece.clusters.size());
  const auto first_triangle = static_cast<uint32_t>(out.triangles.size());
  for (Cluster& cluster : piece.clusters) {
    cluster.first_vertex += primitive.first_vertex;
    cluster.first_triangle += first_triangle;
  }
  append(out.source_vertices, piece.source_vertices);
  append(out.clusters, piece.clusters);
  append(out.triangles, piece.triangles);
  append(out.indices, piece.indices);
  return primitive;
}

void copy_primitive(const Scene& scene, const Primitive& source, ClusteredGeometry& out,
                    ClusteredPrimitive& primitive) {
  primitive.first_index = static_cast<uint32_t>(out.indices.size());
  primitive.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
  primitive.index_count = source.index_count;
  primitive.vertex_count = source.vertex_count;
  const auto first = scene.indices.begin() + source.first_index;
  out.indices.insert(out.indices.end(), first, first + source.index_count);
  for (uint32_t v = 0; v < source.vertex_count; ++v) out.source_vertices.push_back(source.first_vertex + v);
}

}  // namespace

ClusteredGeometry cut_clusters(const Scene& scene, const std::function<void(size_t done)>& progress) {
  ClusteredGeometry out;
  const size_t count = scene.primitives.size();
  const auto is_cut = [&](size_t p) { return scene.primitives[p].topology == Topology::triangles; };
  std::vector<Piece> pieces(count);
  parallel_for(
      count,
      [&](size_t p) {
        if (is_cut(p)) pieces[p] = cut_primitive(scene, scene.primitives[p]);
      },
      progress);
  out.primitives.resize(count);
  out.indices.reserve(scene.indices.size());
  out.triangles.reserve(scene.indices.size() / 3);
  out.source_vertices.reserve(scene.positions.size() + scene.positions.size() / 2);
  for (size_t p = 0; p < count; ++p) {
    if (is_cut(p)) out.primitives[p] = append(out, std::exchange(pieces[p], {}));
  }
  // Behind all triangles, so that those keep their place beside the clusters'.
  for (size_t p = 0; p < count; ++p) {
    if (!is_cut(p)) copy_primitive(scene, scene.primitives[p], out, out.primitives[p]);
  }
  return out;
}

}  // namespace fire3dv::scene
