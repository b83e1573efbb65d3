// Test of ray boxes: each LOD 0 triangle is in exactly one box, within its bounds. The order of the boxes
// gives an efficient tree.
#include "renderer/scene/clusters/ray_boxes.h"
#include "renderer/scene/model/vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <span>

#include "renderer/scene/clusters/clusters.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"

namespace fire3dv::test {
namespace {

using scene::ClusteredGeometry;
using scene::ClusteredPrimitive;
using scene::RayAabb;
using scene::Scene;

Scene scene_of_all_kinds() {
  Scene scene;
  add_primitive(scene, ball_triangles(1, 96, 0.3f));
  for (size_t v = 0; v < scene.positions.size(); ++v)
    scene.frames[v] = scene::packed_frame(scene.positions[v], {1, 0, 0, 1});
  add_primitive(scene, {});
  add_primitive(scene, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {0, 1, 1, 2}}, 0,
                scene::Topology::lines);
  add_mesh(scene);
  add_primitive(scene, box_triangles({1, 2, 3}));
  add_primitive(scene, soup_triangles(3000));
  add_mesh(scene);
  for (uint32_t mesh = 0; mesh < 2; ++mesh) scene.nodes.emplace_back().mesh = mesh;
  return scene;
}

using Boxed = std::map<std::pair<uint32_t, uint32_t>, int>;  // number of boxes with a cluster's triangle

// Collects the triangles of one primitive, and checks that each lies within its box.
Boxed boxed_triangles(const Scene& scene, const ClusteredGeometry& geometry,
                      const ClusteredPrimitive& primitive) {
  Boxed found;
  for (uint32_t b = primitive.first_ray_box; b < primitive.first_ray_box + primitive.ray_box_count; ++b) {
    const RayAabb& box = geometry.ray_boxes[b];
    EXPECT_LE(box.triangle_count(), scene::kRayBoxTriangles);
    for (uint32_t t = box.first_triangle(); t < box.first_triangle() + box.triangle_count(); ++t) {
      ++found[{box.first_vertex, t}];
      for (int corner = 0; corner < 3; ++corner) {
        const uint32_t vertex = box.first_vertex + (geometry.triangles[t] >> (8 * corner) & 255);
        const glm::vec3 place = scene.positions[geometry.source_vertices[vertex]];
        EXPECT_EQ(glm::min(place, box.low), box.low);
        EXPECT_EQ(glm::max(place, box.high), box.high);
      }
    }
  }
  return found;
}

void expect_each_triangle_once(const Scene& scene, const ClusteredGeometry& geometry) {
  for (size_t p = 0; p < scene.primitives.size(); ++p) {
    SCOPED_TRACE(p);
    const ClusteredPrimitive& primitive = geometry.primitives[p];
    Boxed wanted;
    for (uint32_t c = primitive.first_cluster; c < primitive.first_cluster + primitive.cluster_count; ++c) {
      const scene::Cluster& cluster = geometry.clusters[c];
      for (uint32_t t = 0; t < cluster.triangle_count; ++t)
        wanted[{cluster.first_vertex, cluster.first_triangle + t}] = 1;
    }
    EXPECT_EQ(boxed_triangles(scene, geometry, primitive), wanted);
    EXPECT_EQ(primitive.ray_box_count == 0, primitive.cluster_count == 0);
  }
}

TEST(RayBoxes, HoldEachTriangleOnce) {
  const Scene scene = scene_of_all_kinds();
  const ClusteredGeometry geometry = scene::cut_clusters(scene);
  EXPECT_GT(geometry.ray_boxes.size(), 300u);
  expect_each_triangle_once(scene, geometry);
}

TEST(RayBoxes, BoxesHoldFullDetail) {
  const Scene scene = scene_of_all_kinds();
  ClusteredGeometry geometry = scene::cut_clusters(scene);
  scene::add_cluster_levels(scene, geometry);
  ASSERT_GT(geometry.primitives[0].level_cluster_count, 0u);
  expect_each_triangle_once(scene, geometry);
}

TEST(RayBoxes, BoxesFollowMergedAssets) {
  scene::LoadedScene both{scene_of_all_kinds(), {}};
  both.derived.clusters = scene::cut_clusters(both.scene);
  scene::add_cluster_levels(both.scene, both.derived.clusters);  // LOD triangles follow those of LOD 0
  const scene::LoadedScene asset = both;
  const uint32_t below = scene::add_node(both.scene, "asset", 0, glm::mat4(1));
  ASSERT_TRUE(scene::add_below(both, asset, below).ok());
  ASSERT_EQ(both.derived.clusters.ray_boxes.size(), 2 * asset.derived.clusters.ray_boxes.size());
  expect_each_triangle_once(both.scene, both.derived.clusters);
}

double surface_of(std::span<const RayAabb> boxes) {
  glm::dvec3 low(1e30), high(-1e30);
  for (const RayAabb& box : boxes) {
    low = glm::min(low, glm::dvec3(box.low));
    high = glm::max(high, glm::dvec3(box.high));
  }
  const glm::dvec3 size = high - low;
  return 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

// Sum of the node surfaces of a tree that halves the boxes in their order: the expected cost of a ray.
double surface_of_tree(std::span<const RayAabb> boxes) {
  if (boxes.size() < 2) return surface_of(boxes);
  const size_t half = (boxes.size() + 1) / 2;
  return surface_of(boxes) + surface_of_tree(boxes.first(half)) + surface_of_tree(boxes.subspan(half));
}

Scene large_ball() {
  Scene scene;
  add_primitive(scene, ball_triangles(1, 256));
  add_mesh(scene);
  return scene;
}

TEST(RayBoxes, OrderKeepsTreeBoxesSmall) {
  const Scene scene = large_ball();
  const ClusteredGeometry geometry = scene::cut_clusters(scene);
  std::vector<RayAabb> boxes = geometry.ray_boxes;
  const double ordered = surface_of_tree(boxes);
  std::ranges::sort(boxes, {}, [](const RayAabb& box) { return box.first_triangle(); });
  EXPECT_LT(1.5 * ordered, surface_of_tree(boxes)) << "of clusters as they have grown";
}

double surface_of_each(std::span<const RayAabb> boxes) {
  double surface = 0;
  for (const RayAabb& box : boxes) surface += surface_of({&box, 1});
  return surface;
}

TEST(RayBoxes, HoldNeighbours) {
  const Scene scene = large_ball();
  const ClusteredGeometry geometry = scene::cut_clusters(scene);
  std::vector<uint32_t> triangles = geometry.triangles;
  std::mt19937 random(1);
  for (const scene::Cluster& cluster : geometry.clusters) {
    const auto first = triangles.begin() + cluster.first_triangle;
    std::shuffle(first, first + cluster.triangle_count, random);
  }
  const std::vector<RayAabb> any =
      scene::ray_boxes_of(geometry.clusters, triangles, geometry.source_vertices, scene.positions);
  EXPECT_LT(2 * surface_of_each(geometry.ray_boxes), surface_of_each(any));
}

}  // namespace
}  // namespace fire3dv::test
