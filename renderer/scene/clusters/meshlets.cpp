#include "renderer/scene/clusters/meshlets.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace fire3dv::scene {
namespace {

// Weight of normal similarity: clusters with narrow normal cones are culled as a whole if they face away.
constexpr float kConeWeight = 0.25f;
// Minimum cosine between normals and cone axis; wider cones are hardly ever culled.
constexpr double kLeastCosine = 0.1;

// Bounding sphere in double precision: squares of valid coordinates overflow float, those of tiny areas
// underflow.
struct Sphere {
  glm::dvec3 center{0};
  double radius = 0;
};

// Near-minimal bounding sphere (Ritter 1990).
Sphere sphere_around(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  std::array<glm::dvec3, 3> low, high;
  low.fill(points[0]);
  high.fill(points[0]);
  for (const glm::dvec3& point : points) {
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<size_t>(i);
      if (point[i] < low[axis][i]) low[axis] = point;
      if (point[i] > high[axis][i]) high[axis] = point;
    }
  }
  size_t widest = 0;
  for (size_t axis = 1; axis < 3; ++axis) {
    if (glm::distance(low[axis], high[axis]) > glm::distance(low[widest], high[widest])) widest = axis;
  }
  Sphere sphere{0.5 * (low[widest] + high[widest]), 0.5 * glm::distance(low[widest], high[widest])};
  for (const glm::dvec3& point : points) {
    const double away = glm::distance(point, sphere.center);
    if (!(away > sphere.radius)) continue;
    const double grown = 0.5 * (sphere.radius + away);
    sphere.center += (point - sphere.center) * ((away - grown) / away);
    sphere.radius = grown;
  }
  return sphere;
}

// Unit normals of non-degenerate triangles.
std::vector<glm::dvec3> normals_of(std::span<const uint8_t> corners, std::span<const glm::dvec3> points) {
  std::vector<glm::dvec3> normals;
  normals.reserve(corners.size() / 3);
  for (size_t c = 0; c < corners.size(); c += 3) {
    const glm::dvec3& a = points[corners[c]];
    const glm::dvec3 normal = glm::cross(points[corners[c + 1]] - a, points[corners[c + 2]] - a);
    const double length = std::sqrt(glm::dot(normal, normal));
    if (length > 0 && std::isfinite(length)) normals.push_back(normal / length);
  }
  return normals;
}

// Normal cone; cutoff 1 disables culling.
void find_cone(Cluster& cluster, std::span<const glm::dvec3> normals) {
  cluster.cone_cutoff = 1;
  const glm::dvec3 center = sphere_around(normals).center;
  const double length = std::sqrt(glm::dot(center, center));
  if (!(length > 0)) return;
  cluster.cone_axis = center / length;
  double least = 1;
  for (const glm::dvec3& normal : normals)
    least = std::min(least, glm::dot(normal, glm::dvec3(cluster.cone_axis)));
  if (!(least > kLeastCosine)) return;
  // Margin against rounding, so that visible triangles are never culled.
  cluster.cone_cutoff = static_cast<float>(std::min(std::sqrt(1 - least * least) + 1e-3, 1.0));
}

}  // namespace

Meshlets::Meshlets(std::span<const uint32_t> indices, std::span<const glm::vec3> positions)
    : grown(grow_clusters(indices, positions, {kClusterVertices, kClusterTriangles, kConeWeight})) {}

Cluster Meshlets::bounded(const GrownClusters::Run& run, std::span<const glm::vec3> positions) const {
  std::vector<glm::dvec3> points;
  points.reserve(run.vertex_count);
  for (uint32_t v = 0; v < run.vertex_count; ++v)
    points.emplace_back(positions[grown.vertices[run.first_vertex + v]]);
  Cluster cluster;
  cluster.center = sphere_around(points).center;
  double radius2 = 0;
  for (const glm::dvec3& point : points) {
    const glm::dvec3 offset = point - glm::dvec3(cluster.center);
    radius2 = std::max(radius2, glm::dot(offset, offset));
  }
  cluster.radius = static_cast<float>(std::sqrt(radius2) * 1.00001);
  const std::span<const uint8_t> corners(&grown.corners[size_t{3} * run.first_triangle],
                                         size_t{3} * run.triangle_count);
  find_cone(cluster, normals_of(corners, points));
  cluster.vertex_count = run.vertex_count;
  cluster.triangle_count = run.triangle_count;
  return cluster;
}

}  // namespace fire3dv::scene
