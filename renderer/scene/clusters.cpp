#include "renderer/scene/clusters.h"

#include <utility>

#include "renderer/scene/meshlets.h"
#include "renderer/scene/parallel.h"

namespace fire3dv::scene {
namespace {

// What one primitive is cut into, with offsets into its own arrays.
struct Piece {
  std::vector<uint32_t> source_vertices, triangles, indices;
  std::vector<Cluster> clusters;
};

Piece cut_primitive(const Scene& scene, const Primitive& source) {
  Piece out;
  const std::span<const glm::vec3> positions(scene.positions.data() + source.first_vertex,
                                             source.vertex_count);
  const Meshlets cut({scene.indices.data() + source.first_index, source.index_count}, positions);
  out.clusters.reserve(cut.grown.runs.size());
  out.indices.reserve(source.index_count);
  out.triangles.reserve(source.index_count / 3);
  for (const GrownClusters::Run& run : cut.grown.runs) {
    Cluster cluster = cut.bounded(run, positions);
    cluster.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
    cluster.first_triangle = static_cast<uint32_t>(out.triangles.size());
    for (uint32_t v = 0; v < run.vertex_count; ++v) {
      out.source_vertices.push_back(source.first_vertex + cut.grown.vertices[run.first_vertex + v]);
    }
    for (uint32_t t = 0; t < run.triangle_count; ++t) {
      const uint8_t* corner = &cut.grown.corners[size_t{3} * (run.first_triangle + t)];
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
