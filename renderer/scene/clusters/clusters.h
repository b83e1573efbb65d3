// Cluster geometry (meshlets) of the scene: up to 128 adjacent triangles with bounds, the unit of culling and
// rasterisation. Vertices are reordered by cluster so that each cluster has one vertex range. Vertices that
// clusters share are duplicated bit-exactly, so no cracks appear. Also coarser levels of detail
// (cluster_levels.cpp), and copies for deformed nodes.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "base/error.h"
#include "renderer/scene/clusters/ray_boxes.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Measured on an H200 and on lavapipe. A workgroup processes one cluster with one vertex and one triangle per
// thread.
constexpr uint32_t kClusterTriangles = 128;
constexpr uint32_t kClusterVertices = 128;

struct Cluster {
  glm::vec3 center{0};  // bounding sphere in node space
  float radius = 0;
  // Normal cone: all triangles face away from `eye` if dot(center - eye, cone_axis) >= cone_cutoff * |center
  // - eye| + radius.
  glm::vec3 cone_axis{0};
  float cone_cutoff = 1;
  uint32_t first_vertex = 0;    // cluster order; see ClusteredGeometry::source_vertices
  uint32_t first_triangle = 0;  // into ClusteredGeometry::triangles
  uint32_t vertex_count = 0;
  uint32_t triangle_count = 0;
  // LOD groups (add_cluster_levels()): made_by created this cluster, merged_by replaces it by coarser
  // clusters. made_by kNone: LOD 0; merged_by kNone: no coarser level.
  uint32_t made_by = kNone, merged_by = kNone;
};

// Group of clusters that coarser ones replace together. Errors are lengths in node space.
struct LevelGroup {
  glm::vec3 center{0};  // encloses all sources down to LOD 0
  float radius = 0;
  float error = 0;          // appearance difference from LOD 0
  float surface_error = 0;  // geometric part of the error
};

struct ClusteredPrimitive {
  uint32_t first_index = 0, index_count = 0;  // in the list of ClusterIndices
  uint32_t first_vertex = 0, vertex_count = 0;
  uint32_t first_cluster = 0, cluster_count = 0;              // 0 for lines and points
  uint32_t first_level_cluster = 0, level_cluster_count = 0;  // LOD 1 and coarser
  uint32_t first_ray_box = 0, ray_box_count = 0;              // 0 also above kMaxRayBoxTriangles
};

struct ClusteredGeometry {
  std::vector<uint32_t> source_vertices;  // scene vertex of each cluster vertex
  std::vector<Cluster> clusters;          // in primitive order
  std::vector<LevelGroup> level_groups;
  std::vector<RayAabb> ray_boxes;              // LOD 0 triangles, in primitive order
  std::vector<uint32_t> triangles;             // three 8-bit cluster-local vertex indices, lowest byte first
  std::vector<ClusteredPrimitive> primitives;  // as Scene::primitives, then deformed copies
};

// Runs on all cores. `progress` receives the number of finished primitives, on the calling thread.
ClusteredGeometry cut_clusters(const Scene& scene, const std::function<void(size_t done)>& progress = {});

uint64_t index_count(const ClusteredGeometry& geometry);

// Borrows both arguments.
class ClusterIndices {
 public:
  ClusterIndices(const Scene& scene, const ClusteredGeometry& geometry);

  // Writes indices from `first` on, relative to the first vertex of their primitive, on all cores. `to` must
  // not exceed the list.
  void write(uint64_t first, std::span<uint32_t> to) const;

 private:
  // Source of one cluster, or of an unclustered primitive.
  struct Run {
    uint32_t first_index, index_count;
    const uint32_t* triangles;  // packed; null for unclustered primitives
    const uint32_t* indices;    // then plain indices
    uint32_t first_vertex;      // of the cluster, relative to its primitive
  };
  static void write(const Run& run, uint64_t first, std::span<uint32_t> to);

  std::vector<Run> runs_;
};

// Per-instance vertices of deformed nodes (skins, morph targets, replaced vertices). The copies follow the
// scene's vertices; the deform pass rewrites them when a pose changes. Triangles are shared.
//
// True if a skin, morph targets or replaced vertices deform the node.
bool is_deformed(const Node& node);

// True if the joints of a skinned node invert the winding at rest. The node's own transform has no influence.
bool is_mirrored_by_joints(const Scene& scene, const Node& node);

// Upper bound on vertices of a mesh's copy, and of the copies of all deformed nodes.
uint64_t corners_of_mesh(const Scene& scene, const Mesh& mesh);
uint64_t deformed_corners(const Scene& scene);
// About 5 GB of GPU memory if triangles share no vertices.
constexpr uint64_t kMaxDeformedCorners = uint64_t{1} << 26;

// Thousands of nodes may share a deformed mesh; fails above kMaxDeformedCorners.
Result<void> check_deformed_copies(const Scene& scene);

struct DeformedNode {
  uint32_t node = 0;
  uint32_t first_primitive = 0;  // first copied primitive in ClusteredGeometry::primitives
};

// Appends copies in node order.
std::vector<DeformedNode> add_deformed_copies(const Scene& scene, ClusteredGeometry& geometry);

// Cluster LOD hierarchy: groups of adjacent clusters are simplified to about half and cut into clusters again
// (docs/design/levels-of-detail.md). Group borders are locked, and all levels reuse the file's vertices
// bit-exactly. Error and sphere of a group enclose those of its sources. A cluster is drawn if the error of
// made_by is below the limit and that of merged_by is not. This local test selects a watertight set without
// seams (shaders/visibility/level_choice.glsl).
//
// Rays hit LOD 0 triangles, so shadow rays start off the surface by twice surface_error (the factor covers
// sampling). Shadow maps of large scenes contain coarser triangles, dilated by the allowed error
// (shaders/visibility/light_raster.glsl); shadow edges move by at most a quarter of a texel.
//
// Appends coarser clusters, their vertices, triangles and groups to the result of cut_clusters(). Covers
// opaque and alpha-masked triangles of undeformed nodes. The result is independent of the number of threads.
void add_cluster_levels(const Scene& scene, ClusteredGeometry& geometry,
                        const std::function<void(size_t done, size_t total)>& progress = {});

}  // namespace fire3dv::scene
