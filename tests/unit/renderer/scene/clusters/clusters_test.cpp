// Test of mesh clusters: they contain each triangle of the scene once and respect the shaders' limits.
// Bounding spheres and normal cones never cull a visible triangle.
#include "renderer/scene/clusters/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>

#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"

namespace fire3dv::test {
namespace {

using scene::Cluster;
using scene::ClusteredGeometry;
using scene::ClusteredPrimitive;
using scene::Scene;

// Source indices of a triangle, rotated to start with the smallest: the winding stays.
using Face = std::array<uint32_t, 3>;
Face turned(Face face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

Scene mixed_scene() {
  Scene scene;
  add_primitive(scene, ball_triangles(1, 64));
  add_mesh(scene);
  add_primitive(scene, box_triangles({1, 2, 3}));
  add_primitive(scene, {});  // an empty primitive
  add_primitive(scene, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 1, 2, 0}}, 0, scene::Topology::points);
  // Degenerate triangles, a duplicate, coincident vertices.
  add_primitive(scene, {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 1, 0}},
                        {0, 1, 2, 0, 0, 1, 0, 1, 3, 0, 1, 3, 0, 3, 4, 2, 2, 2}});
  add_primitive(scene, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {0, 1, 1, 2}}, 0,
                scene::Topology::lines);
  add_primitive(scene, ball_triangles(0.01f, 48, 0.3f));
  // The vertex limit applies before the triangle limit.
  add_primitive(scene, soup_triangles(3000));
  Triangles fan;  // many triangles at one vertex
  fan.positions.emplace_back(0, 0, 0);
  for (int i = 0; i <= 1000; ++i) {
    fan.positions.emplace_back(std::cos(0.005f * static_cast<float>(i)),
                               std::sin(0.005f * static_cast<float>(i)), 0);
  }
  for (uint32_t i = 1; i <= 1000; ++i) fan.indices.insert(fan.indices.end(), {0, i, i + 1});
  add_primitive(scene, fan);
  add_mesh(scene);
  return scene;
}

std::vector<uint32_t> indices_of(const Scene& scene, const ClusteredGeometry& geometry) {
  std::vector<uint32_t> indices(scene::index_count(geometry));
  scene::ClusterIndices(scene, geometry).write(0, indices);
  return indices;
}

TEST(Clusters, IndicesAreTheSameInPieces) {
  const Scene scene = mixed_scene();
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  const std::vector<uint32_t> whole = indices_of(scene, cut);
  ASSERT_EQ(whole.size(), scene.indices.size());
  const scene::ClusterIndices indices(scene, cut);
  for (const size_t most : {size_t{1}, size_t{7}, size_t{1000}, whole.size()}) {
    for (size_t first = 0; first < whole.size(); first += most) {
      std::vector<uint32_t> piece(std::min(most, whole.size() - first), scene::kNone);
      indices.write(first, piece);
      ASSERT_TRUE(std::equal(piece.begin(), piece.end(), whole.begin() + static_cast<ptrdiff_t>(first)))
          << first;
    }
  }
}

TEST(Clusters, TrianglesKeepWinding) {
  const Scene scene = mixed_scene();
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  const std::vector<uint32_t> indices = indices_of(scene, cut);
  ASSERT_EQ(cut.primitives.size(), scene.primitives.size());
  for (size_t p = 0; p < scene.primitives.size(); ++p) {
    SCOPED_TRACE(p);
    const scene::Primitive& source = scene.primitives[p];
    if (source.topology != scene::Topology::triangles) continue;
    const ClusteredPrimitive& primitive = cut.primitives[p];
    std::map<Face, int> wanted, found_by_indices, found_by_clusters;
    for (uint32_t i = 0; i < source.index_count; i += 3) {
      const uint32_t* index = &scene.indices[source.first_index + i];
      ++wanted[turned(
          {source.first_vertex + index[0], source.first_vertex + index[1], source.first_vertex + index[2]})];
    }
    for (uint32_t i = 0; i < primitive.index_count; i += 3) {
      Face face;
      for (uint32_t c = 0; c < 3; ++c) {
        const uint32_t relative = indices[primitive.first_index + i + c];
        ASSERT_LT(relative, primitive.vertex_count);
        face[c] = cut.source_vertices[primitive.first_vertex + relative];
      }
      ++found_by_indices[turned(face)];
    }
    for (uint32_t c = primitive.first_cluster; c < primitive.first_cluster + primitive.cluster_count; ++c) {
      const Cluster& cluster = cut.clusters[c];
      for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
        const uint32_t packed = cut.triangles[cluster.first_triangle + t];
        Face face;
        for (uint32_t corner = 0; corner < 3; ++corner) {
          const uint32_t local = packed >> (8 * corner) & 255;
          ASSERT_LT(local, cluster.vertex_count);
          face[corner] = cut.source_vertices[cluster.first_vertex + local];
        }
        ++found_by_clusters[turned(face)];
      }
    }
    EXPECT_EQ(found_by_indices, wanted);
    EXPECT_EQ(found_by_clusters, wanted);
  }
}

TEST(Clusters, AreRunsWithinLimitsOfWorkgroup) {
  const Scene scene = mixed_scene();
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  uint32_t next_vertex = 0, next_triangle = 0, next_cluster = 0, next_index = 0;
  bool full_of_vertices = false, full_of_triangles = false;
  for (size_t p = 0; p < scene.primitives.size(); ++p) {
    const ClusteredPrimitive& primitive = cut.primitives[p];
    EXPECT_EQ(primitive.first_vertex, next_vertex);
    EXPECT_EQ(primitive.first_index, next_index);
    next_index += primitive.index_count;
    if (scene.primitives[p].topology != scene::Topology::triangles) {
      EXPECT_EQ(primitive.cluster_count, 0u);
      next_vertex += primitive.vertex_count;
      continue;
    }
    const uint32_t first_triangle = next_triangle;
    EXPECT_EQ(primitive.first_cluster, next_cluster);
    next_cluster += primitive.cluster_count;
    for (uint32_t c = primitive.first_cluster; c < next_cluster; ++c) {
      const Cluster& cluster = cut.clusters[c];
      EXPECT_EQ(cluster.first_vertex, next_vertex);
      EXPECT_EQ(cluster.first_triangle, next_triangle);
      EXPECT_GT(cluster.triangle_count, 0u);
      EXPECT_LE(cluster.triangle_count, 128u);
      EXPECT_LE(cluster.vertex_count, 128u);
      full_of_triangles |= cluster.triangle_count == 128;
      full_of_vertices |= cluster.vertex_count >= 126;
      next_vertex += cluster.vertex_count;
      next_triangle += cluster.triangle_count;
    }
    EXPECT_EQ(primitive.first_vertex + primitive.vertex_count, next_vertex);
    EXPECT_EQ(primitive.index_count, 3 * (next_triangle - first_triangle));
  }
  EXPECT_EQ(cut.clusters.size(), next_cluster);
  EXPECT_EQ(cut.triangles.size(), next_triangle);
  EXPECT_TRUE(full_of_vertices) << "the scene does not reach the limit";
  EXPECT_TRUE(full_of_triangles) << "the scene does not reach the limit";
}

TEST(Clusters, LinesAndPointsAreCopied) {
  const Scene scene = mixed_scene();
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  const std::vector<uint32_t> indices = indices_of(scene, cut);
  for (size_t p = 0; p < scene.primitives.size(); ++p) {
    const scene::Primitive& source = scene.primitives[p];
    if (source.topology == scene::Topology::triangles) continue;
    const ClusteredPrimitive& copy = cut.primitives[p];
    ASSERT_EQ(copy.index_count, source.index_count);
    ASSERT_EQ(copy.vertex_count, source.vertex_count);
    for (uint32_t i = 0; i < source.index_count; ++i) {
      EXPECT_EQ(indices[copy.first_index + i], scene.indices[source.first_index + i]);
    }
    for (uint32_t v = 0; v < source.vertex_count; ++v) {
      EXPECT_EQ(cut.source_vertices[copy.first_vertex + v], source.first_vertex + v);
    }
  }
}

TEST(Clusters, SpheresHoldAllVertices) {
  const Scene scene = mixed_scene();
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  for (const Cluster& cluster : cut.clusters) {
    for (uint32_t v = 0; v < cluster.vertex_count; ++v) {
      const glm::vec3 p = scene.positions[cut.source_vertices[cluster.first_vertex + v]];
      ASSERT_LE(glm::distance(glm::dvec3(p), glm::dvec3(cluster.center)),
                static_cast<double>(cluster.radius));
    }
  }
}

// The guarantee of Cluster::cone_axis, for eyes all around and close by, and for orthographic views.
TEST(Clusters, CulledConeFacesAway) {
  Scene scene;
  add_primitive(scene, ball_triangles(1, 96));
  add_primitive(scene, ball_triangles(1, 64, 0.4f));
  add_primitive(scene, box_triangles({0.5f, 0.02f, 3}));
  const ClusteredGeometry cut = scene::cut_clusters(scene);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-2, 3);
  int culled_by_eye = 0, culled_by_direction = 0;
  for (int i = 0; i < 400; ++i) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    const glm::dvec3 eye = (0.9 + std::pow(10.0, exponent(random))) * direction;
    for (const Cluster& cluster : cut.clusters) {
      const glm::dvec3 axis(cluster.cone_axis), look = glm::dvec3(cluster.center) - eye;
      const bool away_from_eye =
          glm::dot(look, axis) >= double{cluster.cone_cutoff} * glm::length(look) + double{cluster.radius};
      const bool away_from_direction =
          cluster.cone_cutoff < 1 && glm::dot(direction, axis) >= double{cluster.cone_cutoff};
      culled_by_eye += away_from_eye;
      culled_by_direction += away_from_direction;
      if (!away_from_eye && !away_from_direction) continue;
      for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
        const uint32_t packed = cut.triangles[cluster.first_triangle + t];
        glm::dvec3 corner[3];
        for (uint32_t c = 0; c < 3; ++c) {
          corner[c] = scene.positions[cut.source_vertices[cluster.first_vertex + (packed >> (8 * c) & 255)]];
        }
        const glm::dvec3 n = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
        if (away_from_eye) {
          ASSERT_GE(glm::dot(n, corner[0] - eye), 0.0);
        }
        if (away_from_direction) {
          ASSERT_GE(glm::dot(n, direction), 0.0);
        }
      }
    }
  }
  EXPECT_GT(culled_by_eye, 1000) << "the cones are of no use";
  EXPECT_GT(culled_by_direction, 1000);
}

TEST(Clusters, AnEmptySceneHasNone) {
  const ClusteredGeometry cut = scene::cut_clusters({});
  EXPECT_TRUE(cut.clusters.empty() && index_count(cut) == 0 && cut.source_vertices.empty() &&
              cut.primitives.empty());
}

}  // namespace
}  // namespace fire3dv::test
