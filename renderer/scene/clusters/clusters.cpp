#include "renderer/scene/clusters/clusters.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/parallel.h"
#include "base/vectors.h"
#include "renderer/scene/clusters/meshlets.h"

namespace fire3dv::scene {
namespace {

// Clusters of one primitive, with offsets into its own arrays.
struct Piece {
  std::vector<uint32_t> source_vertices, triangles;
  std::vector<Cluster> clusters;
  std::vector<RayAabb> ray_boxes;
};

// Triangles of one cluster, in the order of ray boxes.
std::vector<Corners> triangles_of(const Meshlets& cut, const GrownClusters::Run& run,
                                  std::span<const glm::vec3> positions) {
  std::vector<glm::vec3> vertices;
  for (uint32_t v = 0; v < run.vertex_count; ++v)
    vertices.push_back(positions[cut.grown.vertices[run.first_vertex + v]]);
  std::vector<Corners> triangles;
  for (uint32_t t = 0; t < run.triangle_count; ++t) {
    const uint8_t* corner = &cut.grown.corners[size_t{3} * (run.first_triangle + t)];
    triangles.push_back({corner[0], corner[1], corner[2]});
  }
  order_for_ray_boxes(triangles, vertices);
  return triangles;
}

Piece cut_primitive(const Scene& scene, const Primitive& source) {
  Piece out;
  const std::span<const glm::vec3> positions(scene.positions.data() + source.first_vertex,
                                             source.vertex_count);
  const Meshlets cut({scene.indices.data() + source.first_index, source.index_count}, positions);
  out.clusters.reserve(cut.grown.runs.size());
  out.triangles.reserve(source.index_count / 3);
  for (const GrownClusters::Run& run : cut.grown.runs) {
    Cluster cluster = cut.bounded(run, positions);
    cluster.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
    cluster.first_triangle = static_cast<uint32_t>(out.triangles.size());
    for (uint32_t v = 0; v < run.vertex_count; ++v) {
      out.source_vertices.push_back(source.first_vertex + cut.grown.vertices[run.first_vertex + v]);
    }
    for (const Corners& corners : triangles_of(cut, run, positions)) {
      out.triangles.push_back(corners[0] | uint32_t{corners[1]} << 8 | uint32_t{corners[2]} << 16);
    }
    out.clusters.push_back(cluster);
  }
  out.ray_boxes = ray_boxes_of(out.clusters, out.triangles, out.source_vertices, scene.positions);
  return out;
}

ClusteredPrimitive append(ClusteredGeometry& out, Piece piece) {
  ClusteredPrimitive primitive;
  primitive.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
  primitive.first_cluster = static_cast<uint32_t>(out.clusters.size());
  primitive.vertex_count = static_cast<uint32_t>(piece.source_vertices.size());
  primitive.cluster_count = static_cast<uint32_t>(piece.clusters.size());
  primitive.first_ray_box = static_cast<uint32_t>(out.ray_boxes.size());
  primitive.ray_box_count = static_cast<uint32_t>(piece.ray_boxes.size());
  const auto first_triangle = static_cast<uint32_t>(out.triangles.size());
  for (Cluster& cluster : piece.clusters) {
    cluster.first_vertex += primitive.first_vertex;
    cluster.first_triangle += first_triangle;
  }
  for (RayAabb& box : piece.ray_boxes) {
    box.first_vertex += primitive.first_vertex;
    box.triangles += first_triangle;
  }
  append_all(out.ray_boxes, piece.ray_boxes);
  append_all(out.source_vertices, piece.source_vertices);
  append_all(out.clusters, piece.clusters);
  append_all(out.triangles, piece.triangles);
  return primitive;
}

void drop_ray_boxes(ClusteredGeometry& out) {
  out.ray_boxes = {};
  for (ClusteredPrimitive& primitive : out.primitives) primitive.first_ray_box = primitive.ray_box_count = 0;
}

// Copies an unclustered primitive.
ClusteredPrimitive copy_primitive(const Primitive& source, ClusteredGeometry& out) {
  ClusteredPrimitive primitive;
  primitive.first_vertex = static_cast<uint32_t>(out.source_vertices.size());
  primitive.vertex_count = source.vertex_count;
  for (uint32_t v = 0; v < source.vertex_count; ++v) out.source_vertices.push_back(source.first_vertex + v);
  return primitive;
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
  out.triangles.reserve(scene.indices.size() / 3);
  out.source_vertices.reserve(scene.positions.size() + scene.positions.size() / 2);
  uint32_t next_index = 0;
  for (size_t p = 0; p < count; ++p) {
    const Primitive& source = scene.primitives[p];
    out.primitives[p] = is_cut(p) ? append(out, std::exchange(pieces[p], {})) : copy_primitive(source, out);
    out.primitives[p].first_index = next_index;
    out.primitives[p].index_count = source.index_count;
    next_index += source.index_count;
  }
  if (out.triangles.size() > kMaxRayBoxTriangles) drop_ray_boxes(out);
  return out;
}

uint64_t index_count(const ClusteredGeometry& geometry) {
  uint64_t end = 0;
  for (const ClusteredPrimitive& p : geometry.primitives)
    end = std::max(end, uint64_t{p.first_index} + p.index_count);
  return end;
}

ClusterIndices::ClusterIndices(const Scene& scene, const ClusteredGeometry& geometry) {
  for (size_t i = 0; i < scene.primitives.size(); ++i) {
    const ClusteredPrimitive& primitive = geometry.primitives[i];
    const Primitive& source = scene.primitives[i];
    if (source.topology != Topology::triangles) {
      runs_.push_back({primitive.first_index, primitive.index_count, nullptr,
                       scene.indices.data() + source.first_index, 0});
      continue;
    }
    uint32_t next = primitive.first_index;
    for (const Cluster& cluster :
         std::span(geometry.clusters).subspan(primitive.first_cluster, primitive.cluster_count)) {
      runs_.push_back({next, 3 * cluster.triangle_count, geometry.triangles.data() + cluster.first_triangle,
                       nullptr, cluster.first_vertex - primitive.first_vertex});
      next += 3 * cluster.triangle_count;
    }
  }
}

void ClusterIndices::write(uint64_t first, std::span<uint32_t> to) const {
  constexpr size_t kTurn = 64;
  parallel_for((runs_.size() + kTurn - 1) / kTurn, [&](size_t turn) {
    for (size_t r = turn * kTurn; r < std::min(runs_.size(), (turn + 1) * kTurn); ++r)
      write(runs_[r], first, to);
  });
}

void ClusterIndices::write(const Run& run, uint64_t first, std::span<uint32_t> to) {
  const uint64_t begin = std::max<uint64_t>(run.first_index, first);
  const uint64_t end = std::min<uint64_t>(uint64_t{run.first_index} + run.index_count, first + to.size());
  if (!run.triangles) {
    for (uint64_t i = begin; i < end; ++i) to[i - first] = run.indices[i - run.first_index];
    return;
  }
  const auto corner = [&](uint64_t i) {
    const uint64_t own = i - run.first_index;
    return run.first_vertex + (run.triangles[own / 3] >> (8 * (own % 3)) & 0xff);
  };
  uint64_t i = begin;
  for (; i < end && (i - run.first_index) % 3 != 0; ++i) to[i - first] = corner(i);
  for (; i + 3 <= end; i += 3) {  // whole triangles
    const uint32_t packed = run.triangles[(i - run.first_index) / 3];
    uint32_t* const written = &to[i - first];
    written[0] = run.first_vertex + (packed & 0xff);
    written[1] = run.first_vertex + (packed >> 8 & 0xff);
    written[2] = run.first_vertex + (packed >> 16 & 0xff);
  }
  for (; i < end; ++i) to[i - first] = corner(i);
}

namespace {

void copy_primitive(ClusteredGeometry& geometry, uint32_t index) {
  ClusteredPrimitive copy = geometry.primitives[index];
  const uint32_t source_vertex = copy.first_vertex, source_cluster = copy.first_cluster;
  copy.first_vertex = static_cast<uint32_t>(geometry.source_vertices.size());
  copy.first_cluster = static_cast<uint32_t>(geometry.clusters.size());
  copy.first_level_cluster = copy.level_cluster_count = 0;
  // Boxes of deformed geometry would have to be recomputed each frame.
  copy.first_ray_box = copy.ray_box_count = 0;
  for (uint32_t v = 0; v < copy.vertex_count; ++v) {
    geometry.source_vertices.push_back(geometry.source_vertices[source_vertex + v]);
  }
  for (uint32_t c = 0; c < copy.cluster_count; ++c) {
    Cluster cluster = geometry.clusters[source_cluster + c];
    cluster.first_vertex += copy.first_vertex - source_vertex;
    cluster.merged_by = kNone;  // deformed meshes have no LOD
    geometry.clusters.push_back(cluster);
  }
  geometry.primitives.push_back(copy);
}

}  // namespace

bool is_deformed(const Node& node) {
  return node.mesh != kNone &&
         (node.skin != kNone || node.morph_weight_count > 0 || node.has_instance_vertices);
}

bool is_mirrored_by_joints(const Scene& scene, const Node& node) {
  if (node.skin == kNone) return false;
  const Joint& joint = scene.joints[scene.skins[node.skin].first_joint];
  return glm::determinant(glm::mat3(scene.nodes[joint.node].world_from_node * joint.joint_from_mesh)) < 0;
}

uint64_t corners_of_mesh(const Scene& scene, const Mesh& mesh) {
  uint64_t corners = 0;
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    // Upper bound: clusters duplicate a shared vertex at most once per triangle.
    corners += std::max(scene.primitives[p].vertex_count, scene.primitives[p].index_count);
  }
  return corners;
}

uint64_t deformed_corners(const Scene& scene) {
  uint64_t corners = 0;
  for (const Node& node : scene.nodes) {
    if (is_deformed(node)) corners += corners_of_mesh(scene, scene.meshes[node.mesh]);
  }
  return corners;
}

Result<void> check_deformed_copies(const Scene& scene) {
  if (deformed_corners(scene) <= kMaxDeformedCorners) return {};
  return Error{"the nodes with skins or morph targets have more than " + std::to_string(kMaxDeformedCorners) +
               " corners of triangles together, each node counted for itself; show fewer of them"};
}

std::vector<DeformedNode> add_deformed_copies(const Scene& scene, ClusteredGeometry& geometry) {
  std::vector<DeformedNode> nodes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (!is_deformed(scene.nodes[n])) continue;
    nodes.push_back({n, static_cast<uint32_t>(geometry.primitives.size())});
    const Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      copy_primitive(geometry, p);
    }
  }
  return nodes;
}

}  // namespace fire3dv::scene
