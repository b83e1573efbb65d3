// Test of cluster levels of detail (LOD): each selection covers the surface once, without cracks, and within
// its stated error of LOD 0.
#include "renderer/scene/clusters/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"
#include "tests/unit/renderer/scene/model/vertex_attributes.h"

namespace fire3dv::test {
namespace {

using scene::Cluster;
using scene::ClusteredGeometry;
using scene::kNone;
using scene::LevelGroup;
using scene::Scene;

void smooth_normals(Scene& scene) {
  for (const scene::Primitive& primitive : scene.primitives) {
    std::vector<glm::dvec3> sums(primitive.vertex_count, glm::dvec3(0));
    for (uint32_t i = 0; i < primitive.index_count; i += 3) {
      const uint32_t* index = &scene.indices[primitive.first_index + i];
      glm::dvec3 p[3];
      for (int c = 0; c < 3; ++c) p[c] = scene.positions[primitive.first_vertex + index[c]];
      for (int c = 0; c < 3; ++c) sums[index[c]] += glm::cross(p[1] - p[0], p[2] - p[0]);
    }
    for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
      if (glm::dot(sums[v], sums[v]) > 0)
        scene.frames[primitive.first_vertex + v] = scene::packed_frame(glm::normalize(sums[v]), {1, 0, 0, 1});
    }
  }
}

void add_node(Scene& scene) {
  add_mesh(scene);
  scene.nodes.emplace_back();
  scene.nodes.back().mesh = static_cast<uint32_t>(scene.meshes.size() - 1);
}

Scene scene_of(const Triangles& triangles) {
  Scene scene;
  add_primitive(scene, triangles);
  add_node(scene);
  smooth_normals(scene);
  return scene;
}

Triangles grid_triangles(uint32_t side, const std::function<float(float, float)>& height) {
  Triangles grid;
  for (uint32_t y = 0; y <= side; ++y) {
    for (uint32_t x = 0; x <= side; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(side),
                  v = static_cast<float>(y) / static_cast<float>(side);
      grid.positions.emplace_back(u, height(u, v), -v);
      if (x == side || y == side) continue;
      const uint32_t a = y * (side + 1) + x, b = a + side + 1;
      for (uint32_t i : {a, a + 1, b, b, a + 1, b + 1}) grid.indices.push_back(i);
    }
  }
  return grid;
}

ClusteredGeometry levels_of(const Scene& scene) {
  ClusteredGeometry geometry = scene::cut_clusters(scene);
  scene::add_cluster_levels(scene, geometry);
  return geometry;
}

// Selection rule of shaders/visibility/level_choice.glsl, for a perspective view and an untransformed node.
struct Eye {
  glm::vec3 position{0}, look{0, 0, -1};
  float level_scale = 0;

  bool shows_error(const LevelGroup& group) const {
    const glm::vec3 center = group.center - position;
    const float radius = group.radius * 1.0001f;
    const float depth = std::max(glm::dot(look, center) - radius, 0.0f);
    return group.error * level_scale * (glm::length(center) + radius) > depth * depth;
  }
};

template <typename Shows>
std::vector<uint32_t> chosen(const ClusteredGeometry& geometry, const Shows& shows_error) {
  std::vector<uint32_t> clusters;
  for (uint32_t c = 0; c < geometry.clusters.size(); ++c) {
    const Cluster& cluster = geometry.clusters[c];
    if (cluster.made_by != kNone && shows_error(geometry.level_groups[cluster.made_by])) continue;
    if (cluster.merged_by != kNone && !shows_error(geometry.level_groups[cluster.merged_by])) continue;
    clusters.push_back(c);
  }
  return clusters;
}

template <typename Use>
void each_triangle(const Scene& scene, const ClusteredGeometry& geometry, const Cluster& cluster,
                   const Use& use) {
  for (uint32_t t = 0; t < cluster.triangle_count; ++t) {
    const uint32_t packed = geometry.triangles[cluster.first_triangle + t];
    glm::vec3 corner[3];
    for (uint32_t c = 0; c < 3; ++c) {
      const uint32_t local = packed >> (8 * c) & 255;
      ASSERT_LT(local, cluster.vertex_count);
      corner[c] = scene.positions[geometry.source_vertices[cluster.first_vertex + local]];
    }
    use(corner);
  }
}

using Place = std::array<uint32_t, 3>;  // bits of a position
Place place_of(const glm::vec3& p) {
  Place place;
  std::memcpy(place.data(), &p, sizeof(place));
  return place;
}

// Counts the edges without exactly two triangles of opposite directions.
size_t open_edges_of(const Scene& scene, const ClusteredGeometry& geometry,
                     const std::vector<uint32_t>& clusters) {
  std::map<std::pair<Place, Place>, int> edges;
  for (uint32_t c : clusters) {
    each_triangle(scene, geometry, geometry.clusters[c], [&](const glm::vec3* corner) {
      for (int i = 0; i < 3; ++i) ++edges[{place_of(corner[i]), place_of(corner[(i + 1) % 3])}];
    });
  }
  size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    open += count != 1 || back == edges.end() || back->second != 1 ? 1 : 0;
  }
  return open;
}

std::vector<int> depths_of(const ClusteredGeometry& geometry) {
  std::vector<int> of_group(geometry.level_groups.size(), 0), depths;
  for (const Cluster& cluster : geometry.clusters) {  // finer clusters precede coarser ones
    const int depth = cluster.made_by == kNone ? 0 : of_group[cluster.made_by] + 1;
    if (cluster.merged_by != kNone)
      of_group[cluster.merged_by] = std::max(of_group[cluster.merged_by], depth);
    depths.push_back(depth);
  }
  return depths;
}

TEST(ClusterLevels, LevelsHalveTriangles) {
  const Scene scene = scene_of(ball_triangles(1, 160));
  const ClusteredGeometry geometry = levels_of(scene);
  const std::vector<int> depths = depths_of(geometry);
  std::map<int, uint32_t> triangles;
  uint32_t coarsest = 0;
  for (size_t c = 0; c < geometry.clusters.size(); ++c) {
    triangles[depths[c]] += geometry.clusters[c].triangle_count;
    coarsest += geometry.clusters[c].merged_by == kNone ? geometry.clusters[c].triangle_count : 0;
  }
  ASSERT_GE(triangles.size(), 6u);
  for (int level = 1; level < 6; ++level) {
    EXPECT_LT(triangles[level], 0.65 * triangles[level - 1]) << level;
    EXPECT_GT(triangles[level], 0.35 * triangles[level - 1]) << level;
  }
  EXPECT_LT(coarsest, 400u) << "of " << triangles[0];
}

TEST(ClusterLevels, ClustersStayWithinLimits) {
  const Scene scene = scene_of(ball_triangles(1, 96, 0.3f));
  const ClusteredGeometry own = scene::cut_clusters(scene), geometry = levels_of(scene);
  ASSERT_GT(geometry.clusters.size(), own.clusters.size());
  EXPECT_TRUE(std::equal(own.triangles.begin(), own.triangles.end(), geometry.triangles.begin()));
  EXPECT_TRUE(
      std::equal(own.source_vertices.begin(), own.source_vertices.end(), geometry.source_vertices.begin()));
  const scene::ClusteredPrimitive& primitive = geometry.primitives[0];
  EXPECT_EQ(primitive.first_level_cluster, own.clusters.size());
  EXPECT_EQ(primitive.first_level_cluster + primitive.level_cluster_count, geometry.clusters.size());
  EXPECT_EQ(primitive.vertex_count, own.primitives[0].vertex_count);
  for (const Cluster& cluster : geometry.clusters) {
    ASSERT_GT(cluster.triangle_count, 0u);
    ASSERT_LE(cluster.triangle_count, scene::kClusterTriangles);
    ASSERT_LE(cluster.vertex_count, scene::kClusterVertices);
    ASSERT_LE(cluster.first_triangle + cluster.triangle_count, geometry.triangles.size());
    ASSERT_LE(cluster.first_vertex + cluster.vertex_count, geometry.source_vertices.size());
    each_triangle(scene, geometry, cluster, [&](const glm::vec3* corner) {
      for (int i = 0; i < 3; ++i) ASSERT_LE(glm::distance(corner[i], cluster.center), cluster.radius);
      for (uint32_t group : {cluster.made_by, cluster.merged_by}) {
        if (group == kNone) continue;
        const LevelGroup& g = geometry.level_groups[group];
        for (int i = 0; i < 3; ++i) ASSERT_LE(glm::distance(corner[i], g.center), g.radius);
      }
    });
  }
}

TEST(ClusterLevels, CoarserErrorsContainFiner) {
  const Scene scene = scene_of(ball_triangles(2, 128, 0.2f));
  const ClusteredGeometry geometry = levels_of(scene);
  int used = 0;
  for (const Cluster& cluster : geometry.clusters) {
    if (cluster.made_by == kNone || cluster.merged_by == kNone) continue;
    const LevelGroup &finer = geometry.level_groups[cluster.made_by],
                     &coarser = geometry.level_groups[cluster.merged_by];
    EXPECT_GE(coarser.error, finer.error);
    EXPECT_GE(coarser.surface_error, finer.surface_error);
    EXPECT_LE(glm::distance(glm::dvec3(finer.center), glm::dvec3(coarser.center)) + finer.radius,
              coarser.radius);
    ++used;
  }
  EXPECT_GT(used, 50);
}

TEST(ClusterLevels, EveryChoiceIsClosed) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> exponent(0, 1);
  Triangles two = ball_triangles(1, 96);
  two.add(ball_triangles(0.3f, 64, 0.3f), {1.6f, 0, 0});
  size_t mixed = 0, views = 0;
  for (const Triangles& shape : {ball_triangles(1, 160), ball_triangles(1, 128, 0.25f), two}) {
    const Scene scene = scene_of(shape);
    const ClusteredGeometry geometry = levels_of(scene);
    const std::vector<int> depths = depths_of(geometry);
    for (int i = 0; i < 40; ++i, ++views) {
      Eye eye;
      const glm::vec3 direction = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
      eye.position = direction * (1.05f + 5 * std::pow(exponent(random), 4.0f));
      eye.look = -direction;
      eye.level_scale = std::pow(10.0f, 0.5f + 2 * exponent(random));
      const std::vector<uint32_t> clusters =
          chosen(geometry, [&](const LevelGroup& g) { return eye.shows_error(g); });
      ASSERT_EQ(open_edges_of(scene, geometry, clusters), 0u) << "view " << i;
      std::set<int> levels;
      for (uint32_t c : clusters) levels.insert(depths[c]);
      mixed += levels.size() >= 2 ? 1 : 0;
    }
  }
  EXPECT_GT(mixed, views / 4) << "levels hardly ever meet: the test says little";
}

float distance_to_triangle(const glm::vec3& p, const glm::vec3* t) {
  const glm::dvec3 a(t[0]), b(t[1]), c(t[2]), q(p);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  double best = INFINITY;
  if (glm::dot(n, n) > 0) {
    const glm::dvec3 on_plane = q - n * (glm::dot(q - a, n) / glm::dot(n, n));
    if (glm::dot(glm::cross(b - a, on_plane - a), n) >= 0 &&
        glm::dot(glm::cross(c - b, on_plane - b), n) >= 0 &&
        glm::dot(glm::cross(a - c, on_plane - c), n) >= 0) {
      best = glm::distance(q, on_plane);
    }
  }
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
    const glm::dvec3 d = to - from;
    const double along =
        glm::dot(d, d) > 0 ? glm::clamp(glm::dot(q - from, d) / glm::dot(d, d), 0.0, 1.0) : 0.0;
    best = std::min(best, glm::distance(q, from + along * d));
  }
  return static_cast<float>(best);
}

TEST(ClusterLevels, SurfaceErrorIsBounded) {
  for (float bump : {0.0f, 0.25f}) {
    const Scene scene = scene_of(ball_triangles(1, 72, bump));
    const ClusteredGeometry geometry = levels_of(scene);
    for (float allowed : {0.003f, 0.01f, 0.04f, 0.2f}) {
      const std::vector<uint32_t> clusters =
          chosen(geometry, [&](const LevelGroup& g) { return g.error > allowed; });
      float claimed = 0, max_distance = 0;
      std::vector<glm::vec3> corners;
      for (uint32_t c : clusters) {
        const Cluster& cluster = geometry.clusters[c];
        if (cluster.made_by != kNone) {
          claimed = std::max(claimed, geometry.level_groups[cluster.made_by].surface_error);
          EXPECT_LE(geometry.level_groups[cluster.made_by].error, allowed);
        }
        each_triangle(scene, geometry, cluster,
                      [&](const glm::vec3* corner) { corners.insert(corners.end(), corner, corner + 3); });
      }
      for (const glm::vec3& p : scene.positions) {
        float nearest = INFINITY;
        for (size_t t = 0; t < corners.size(); t += 3)
          nearest = std::min(nearest, distance_to_triangle(p, &corners[t]));
        max_distance = std::max(max_distance, nearest);
      }
      EXPECT_LE(max_distance, claimed + 1e-6f) << "bump " << bump << ", error " << allowed;
      if (allowed > 0.1f && bump == 0) {
        EXPECT_GT(max_distance, 0.01f * claimed) << "the claim says nothing";
        EXPECT_LT(corners.size(), scene.indices.size() / 4);
      }
    }
  }
}

// Shadow maps select by surface error alone. Neither surface is farther from the other than allowed, although
// the builder measures samples only.
TEST(ClusterLevels, ErrorChoiceIsCoarser) {
  const Scene scene = scene_of(ball_triangles(1, 72, 0.02f));
  const ClusteredGeometry geometry = levels_of(scene);
  std::vector<glm::vec3> own;
  for (uint32_t index : scene.indices) own.push_back(scene.positions[index]);
  const auto distance_to = [](const std::vector<glm::vec3>& corners, const glm::vec3& p) {
    float nearest = INFINITY;
    for (size_t t = 0; t < corners.size(); t += 3)
      nearest = std::min(nearest, distance_to_triangle(p, &corners[t]));
    return nearest;
  };
  const auto corners_of = [&](const std::vector<uint32_t>& clusters) {
    std::vector<glm::vec3> corners;
    for (uint32_t c : clusters)
      each_triangle(scene, geometry, geometry.clusters[c],
                    [&](const glm::vec3* corner) { corners.insert(corners.end(), corner, corner + 3); });
    return corners;
  };
  for (float allowed : {0.02f, 0.06f}) {
    const auto by_looks =
        corners_of(chosen(geometry, [&](const LevelGroup& g) { return g.error > allowed; }));
    const auto by_surface =
        corners_of(chosen(geometry, [&](const LevelGroup& g) { return g.surface_error > allowed; }));
    EXPECT_LE(by_surface.size(), by_looks.size() / 2) << allowed;
    for (const glm::vec3& p : scene.positions) ASSERT_LE(distance_to(by_surface, p), allowed);
    for (size_t t = 0; t < by_surface.size(); t += 3) {
      const glm::vec3 center = (by_surface[t] + by_surface[t + 1] + by_surface[t + 2]) / 3.0f;
      ASSERT_LE(distance_to(own, center), allowed);
    }
  }
}

float largest_error(const ClusteredGeometry& geometry, float LevelGroup::*error) {
  float largest = 0;
  for (const LevelGroup& group : geometry.level_groups) largest = std::max(largest, group.*error);
  return largest;
}

TEST(ClusterLevels, OnlyVisibleDifferencesCost) {
  Scene flat = scene_of(grid_triangles(64, [](float, float) { return 0.0f; }));
  for (size_t v = 0; v < flat.positions.size(); ++v) flat.uvs[v] = {flat.positions[v].x, flat.positions[v].z};
  flat.materials[0].base_color_texture.texture = 0;
  const ClusteredGeometry plain = levels_of(flat);
  EXPECT_GT(plain.level_groups.size(), 4u);
  EXPECT_LT(largest_error(plain, &LevelGroup::error), 1e-4f);

  auto with = [&](const std::function<void(scene::VertexAttributes&, const glm::vec3&)>& change) {
    Scene changed = flat;
    std::vector<scene::VertexAttributes> attributes = attributes_of(changed);
    for (size_t v = 0; v < attributes.size(); ++v) change(attributes[v], changed.positions[v]);
    set_attributes(changed, attributes);
    return levels_of(changed);
  };
  const ClusteredGeometry waves = with([](scene::VertexAttributes& a, const glm::vec3& p) {
    a.normal = glm::normalize(glm::vec3(0.5f * std::sin(40 * p.x), 1, 0.5f * std::sin(40 * p.z)));
  });
  EXPECT_GT(largest_error(waves, &LevelGroup::error), 0.02f) << "normals";
  EXPECT_LT(largest_error(waves, &LevelGroup::surface_error),
            0.5f * largest_error(waves, &LevelGroup::error));
  const ClusteredGeometry bent = with([](scene::VertexAttributes& a, const glm::vec3& p) {
    a.uv0 += 0.05f * glm::vec2(std::sin(30 * p.z), std::sin(30 * p.x));
  });
  EXPECT_GT(largest_error(bent, &LevelGroup::error), 0.005f) << "texture coordinates";
  const ClusteredGeometry painted = with([](scene::VertexAttributes& a, const glm::vec3& p) {
    a.color.r = 0.5f + 0.5f * std::sin(40 * p.x) * std::sin(40 * p.z);
  });
  EXPECT_GT(largest_error(painted, &LevelGroup::error), 0.02f) << "colours";
}

TEST(ClusterLevels, FlatMeshesHaveLevels) {
  const Triangles ball = ball_triangles(1, 96);
  Triangles apart;
  for (uint32_t index : ball.indices) {
    apart.indices.push_back(static_cast<uint32_t>(apart.positions.size()));
    apart.positions.push_back(ball.positions[index]);
  }
  const Scene scene = scene_of(apart);
  const ClusteredGeometry geometry = levels_of(scene);
  const std::vector<uint32_t> clusters = chosen(geometry, [](const LevelGroup& g) { return g.error > 0.3f; });
  uint32_t triangles = 0;
  for (uint32_t c : clusters) triangles += geometry.clusters[c].triangle_count;
  EXPECT_LT(triangles, scene.indices.size() / 3 / 4);
  EXPECT_EQ(open_edges_of(scene, geometry, clusters), 0u);
}

TEST(ClusterLevels, UnsupportedMeshesHaveNoLevels) {
  Scene scene;
  add_primitive(scene, ball_triangles(1, 64));  // of a mesh with a morphed node only
  add_node(scene);
  scene.nodes.back().morph_weight_count = 1;
  scene.materials.emplace_back();
  scene.materials.back().alpha_mode = scene::AlphaMode::blend;
  add_primitive(scene, ball_triangles(1, 64), 1);
  add_primitive(scene, ball_triangles(1, 64), 0, scene::Topology::points);
  add_node(scene);
  add_primitive(scene, ball_triangles(1, 64));  // of a mesh without a node
  add_mesh(scene);
  EXPECT_TRUE(levels_of(scene).level_groups.empty());
  scene.materials[1].alpha_mode = scene::AlphaMode::mask;
  const ClusteredGeometry geometry = levels_of(scene);
  for (size_t p = 0; p < geometry.primitives.size(); ++p)
    EXPECT_EQ(geometry.primitives[p].level_cluster_count > 0, p == 1) << p;
}

// Degenerate triangles, coincident vertices, duplicates, needles, positions far from the origin, triangle
// soup.
TEST(ClusterLevels, BadMeshesDoNoHarm) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-1, 1);
  std::uniform_int_distribution<uint32_t> any(0, 99);
  Scene scene;
  Triangles soup, knot, same, far_away = ball_triangles(1e-3f, 64), huge = ball_triangles(1e30f, 64);
  for (uint32_t i = 0; i < 3000; ++i) {
    soup.positions.emplace_back(place(random), place(random), place(random));
    soup.indices.push_back(i);
    knot.indices.push_back(any(random));
    same.indices.push_back(i % 3);
  }
  knot.positions.assign(soup.positions.begin(), soup.positions.begin() + 100);
  same.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (glm::vec3& p : far_away.positions) p += 1e6f;
  Triangles line = grid_triangles(32, [](float, float) { return 0.0f; });
  for (glm::vec3& p : line.positions) p.z = 0;
  for (const Triangles& shape : {soup, knot, same, far_away, huge, line}) {
    add_primitive(scene, shape);
    add_node(scene);
  }
  const ClusteredGeometry geometry = levels_of(scene);
  for (const Cluster& cluster : geometry.clusters) {
    ASSERT_LE(cluster.triangle_count, scene::kClusterTriangles);
    if (cluster.made_by == kNone) continue;
    ASSERT_LT(cluster.made_by, geometry.level_groups.size());
    const LevelGroup& group = geometry.level_groups[cluster.made_by];
    ASSERT_TRUE(std::isfinite(group.error) && std::isfinite(group.radius));
  }
}

TEST(ClusterLevels, AreTheSameEachTime) {
  Scene scene = scene_of(ball_triangles(1, 128, 0.2f));
  add_primitive(scene, ball_triangles(0.5f, 64));
  add_primitive(scene, box_triangles({1, 2, 3}));
  add_node(scene);
  const ClusteredGeometry first = levels_of(scene);
  static_assert(std::has_unique_object_representations_v<std::array<uint32_t, 14>> &&
                sizeof(Cluster) == 14 * 4);
  for (int i = 0; i < 5; ++i) {
    const ClusteredGeometry again = levels_of(scene);
    ASSERT_EQ(again.clusters.size(), first.clusters.size());
    EXPECT_EQ(
        std::memcmp(again.clusters.data(), first.clusters.data(), first.clusters.size() * sizeof(Cluster)),
        0);
    EXPECT_EQ(again.triangles, first.triangles);
    EXPECT_EQ(again.source_vertices, first.source_vertices);
    ASSERT_EQ(again.level_groups.size(), first.level_groups.size());
    EXPECT_EQ(std::memcmp(again.level_groups.data(), first.level_groups.data(),
                          first.level_groups.size() * sizeof(LevelGroup)),
              0);
  }
}

}  // namespace
}  // namespace fire3dv::test
