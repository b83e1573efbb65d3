// The scene's triangles cut into clusters: groups of up to 128 neighbouring triangles with bounds, that a GPU
// culls and rasterises as one. Vertices are put in cluster order, those that several clusters share once for
// each of them, so that a cluster's vertices are one run; the copies are equal to the bit and no crack can
// open between clusters.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/ray_boxes.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

// Measured on an H200 and on lavapipe; a workgroup takes one cluster, one vertex and one triangle for each
// thread.
constexpr uint32_t kClusterTriangles = 128;
constexpr uint32_t kClusterVertices = 128;

struct Cluster {
  glm::vec3 center{0};  // bounding sphere, node space
  float radius = 0;
  // No triangle faces a viewer at `eye` when dot(center - eye, cone_axis) >= cone_cutoff * |center - eye| +
  // radius.
  glm::vec3 cone_axis{0};
  float cone_cutoff = 1;
  uint32_t first_vertex = 0;    // of ClusteredGeometry's order
  uint32_t first_triangle = 0;  // into ClusteredGeometry::triangles
  uint32_t vertex_count = 0;
  uint32_t triangle_count = 0;
  // Levels of detail, see cluster_levels.h: the group whose simplification made this cluster, and the one
  // that was simplified into coarser ones. kNone: as the file has it; nothing is coarser.
  uint32_t made_by = kNone, merged_by = kNone;
};

// Clusters that are replaced by coarser ones together. Errors are lengths in node space.
struct LevelGroup {
  glm::vec3 center{0};  // sphere around all that it was made from, down to the finest level
  float radius = 0;
  float error = 0;          // how far its simplification is from what the file has, as it looks
  float surface_error = 0;  // of that, how far the surface itself has moved
};

struct ClusteredPrimitive {
  uint32_t first_index = 0, index_count = 0;  // of the list that cluster_indices.h writes
  uint32_t first_vertex = 0, vertex_count = 0;
  uint32_t first_cluster = 0, cluster_count = 0;              // none for lines and points
  uint32_t first_level_cluster = 0, level_cluster_count = 0;  // the coarser ones
  uint32_t first_ray_box = 0, ray_box_count = 0;  // none, too, where the scene has more than boxes can name
};

struct ClusteredGeometry {
  std::vector<uint32_t> source_vertices;  // [vertex here] = vertex of the scene
  std::vector<Cluster> clusters;          // in the order of the primitives
  std::vector<LevelGroup> level_groups;
  std::vector<RayBox> ray_boxes;    // around the file's own triangles, in the order of the primitives
  std::vector<uint32_t> triangles;  // three 8-bit vertex numbers inside the cluster, lowest first
  std::vector<ClusteredPrimitive> primitives;  // as Scene::primitives; behind them deformed_copies.h's
};

// On all cores. `progress` is told, on the calling thread, how many primitives are done.
ClusteredGeometry cut_clusters(const Scene& scene, const std::function<void(size_t done)>& progress = {});

}  // namespace fire3dv::scene
