// Test of cluster growth: clusters are full and compact, separate distant parts, and grow in linear time on
// adversarial meshes.
#include "renderer/scene/clusters/meshlets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"

namespace fire3dv::test {
namespace {

using scene::GrownClusters;

// A planar grid with this number of squares along each side, two triangles each.
Triangles flat_grid(uint32_t squares) {
  Triangles grid;
  for (uint32_t y = 0; y <= squares; ++y) {
    for (uint32_t x = 0; x <= squares; ++x) grid.positions.emplace_back(x, y, 0);
  }
  const uint32_t row = squares + 1;
  for (uint32_t y = 0; y < squares; ++y) {
    for (uint32_t x = 0; x < squares; ++x) {
      const uint32_t at = y * row + x;
      grid.indices.insert(grid.indices.end(), {at, at + 1, at + row, at + 1, at + row + 1, at + row});
    }
  }
  return grid;
}

constexpr scene::GrowthLimits kLimits{128, 128, 0.25f};

// Returns the vertex indices of each cluster's triangles.
std::vector<std::vector<uint32_t>> clusters_of(const Triangles& mesh) {
  const GrownClusters grown = scene::grow_clusters(mesh.indices, mesh.positions, kLimits);
  std::vector<std::vector<uint32_t>> clusters;
  for (const GrownClusters::Run& run : grown.runs) {
    std::vector<uint32_t>& cluster = clusters.emplace_back();
    for (uint32_t c = 3 * run.first_triangle; c < 3 * (run.first_triangle + run.triangle_count); ++c)
      cluster.push_back(grown.vertices[run.first_vertex + grown.corners[c]]);
  }
  return clusters;
}

float reach_of(const std::vector<uint32_t>& cluster, const Triangles& mesh) {
  glm::vec3 low(1e30f), high(-1e30f);
  for (const uint32_t vertex : cluster) {
    low = glm::min(low, mesh.positions[vertex]);
    high = glm::max(high, mesh.positions[vertex]);
  }
  return 0.5f * glm::length(high - low);
}

size_t triangles_in(const std::vector<std::vector<uint32_t>>& clusters) {
  return std::accumulate(clusters.begin(), clusters.end(), size_t{0},
                         [](size_t sum, const auto& cluster) { return sum + cluster.size() / 3; });
}

Triangles shuffled(Triangles mesh) {
  std::vector<std::array<uint32_t, 3>> faces(mesh.indices.size() / 3);
  for (size_t f = 0; f < faces.size(); ++f)
    faces[f] = {mesh.indices[3 * f], mesh.indices[3 * f + 1], mesh.indices[3 * f + 2]};
  std::shuffle(faces.begin(), faces.end(), std::mt19937(5));
  for (size_t f = 0; f < faces.size(); ++f) std::copy_n(faces[f].begin(), 3, &mesh.indices[3 * f]);
  return mesh;
}

TEST(ClusterGrowth, GridClustersAreFull) {
  // In grid order and shuffled.
  for (const Triangles& grid : {flat_grid(128), shuffled(flat_grid(128))}) {
    const auto clusters = clusters_of(grid);
    const size_t triangles = triangles_in(clusters);
    EXPECT_EQ(triangles, grid.indices.size() / 3);
    EXPECT_LT(static_cast<double>(clusters.size()), 1.1 * static_cast<double>(triangles) / 128);
    // Half the diagonal of a square with this number of triangles.
    const float side = grid.positions.back().x - grid.positions.front().x;
    const float square = side * std::sqrt(128.0f / static_cast<float>(triangles)) * 0.7071f;
    float sum = 0;
    for (const auto& cluster : clusters) sum += reach_of(cluster, grid);
    EXPECT_LT(sum / static_cast<float>(clusters.size()), 1.5f * square);
  }
}

TEST(ClusterGrowth, DistantPartsShareNone) {
  Triangles islands;
  const Triangles island = flat_grid(8);  // half a cluster's number of triangles
  for (uint32_t i = 0; i < 40; ++i) {
    const auto first = static_cast<uint32_t>(islands.positions.size());
    for (const glm::vec3& p : island.positions)
      islands.positions.push_back(p + glm::vec3(1000.0f * static_cast<float>(i * 7 % 40), 0, 0));
    for (const uint32_t index : island.indices) islands.indices.push_back(first + index);
  }
  const auto clusters = clusters_of(islands);
  EXPECT_EQ(triangles_in(clusters), islands.indices.size() / 3);
  for (const auto& cluster : clusters) EXPECT_LT(reach_of(cluster, islands), 10);
}

// Neighbouring triangles share a cluster without common vertices.
TEST(ClusterGrowth, SeparateTrianglesAreGrouped) {
  Triangles grid = flat_grid(64), separate;
  for (uint32_t i = 0; i < grid.indices.size(); ++i) {
    separate.positions.push_back(grid.positions[grid.indices[i]]);
    separate.indices.push_back(i);
  }
  const auto clusters = clusters_of(shuffled(separate));
  EXPECT_EQ(triangles_in(clusters), grid.indices.size() / 3);
  EXPECT_LT(static_cast<double>(clusters.size()), 1.1 * static_cast<double>(grid.indices.size() / 3) / 42);
  const float side = grid.positions.back().x - grid.positions.front().x;
  float sum = 0;
  for (const auto& cluster : clusters) sum += reach_of(cluster, separate);
  EXPECT_LT(sum / static_cast<float>(clusters.size()), 0.25f * side);
}

// An algorithm that visits all triangles of a vertex for each of them takes hours here.
TEST(ClusterGrowth, HugeFanIsFast) {
  Triangles fan;
  constexpr uint32_t kBlades = 500'000;
  fan.positions.emplace_back(0, 0, 0);
  for (uint32_t i = 0; i <= kBlades; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / kBlades;
    fan.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  for (uint32_t i = 1; i <= kBlades; ++i) fan.indices.insert(fan.indices.end(), {0, i, i + 1});
  Triangles blades = fan;  // the same fan with separate vertices except for the centre
  for (uint32_t i = 0; i < kBlades; ++i) {
    blades.positions.push_back(fan.positions[i + 2]);
    blades.indices[3 * i + 2] = static_cast<uint32_t>(blades.positions.size() - 1);
  }
  for (const Triangles& mesh : {fan, shuffled(fan), blades, shuffled(blades)}) {
    const auto clusters = clusters_of(mesh);
    EXPECT_EQ(triangles_in(clusters), kBlades);
    EXPECT_LT(clusters.size(), kBlades / 30);
  }
}

}  // namespace
}  // namespace fire3dv::test
