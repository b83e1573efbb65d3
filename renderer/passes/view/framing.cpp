#include "renderer/passes/view/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "renderer/passes/view/view.h"
#include "renderer/scene/model/bounds.h"

namespace fire3dv::passes {
namespace {

constexpr size_t kMaxPrimitives = 100'000;
constexpr size_t kMaxPoints = 200'000;

bool is_finite(const glm::vec3& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

void add_corners(const glm::vec3& low, const glm::vec3& high, const glm::mat4& world_from_box,
                 std::vector<glm::vec3>& points) {
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 at(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z,
                       1);
    const glm::vec3 world(world_from_box * at);
    if (is_finite(world)) points.push_back(world);
  }
}

// A posed vertex is inside the convex hull of the posed boxes of its joints.
void add_joint_corners(const scene::Scene& scene, uint32_t skinned_node,
                       std::span<const glm::mat4> world_from_node, std::vector<glm::vec3>& points) {
  const scene::Node& node = scene.nodes[skinned_node];
  const scene::Mesh& mesh = scene.meshes[node.mesh];
  const scene::Skin& skin = scene.skins[node.skin];
  for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
    const scene::Primitive& primitive = scene.primitives[p];
    if (primitive.joint_bounds_count == 0)  // rigid
      add_corners(primitive.bounds_min, primitive.bounds_max, world_from_node[skinned_node], points);
    for (uint32_t b = 0; b < primitive.joint_bounds_count; ++b) {
      const scene::JointBounds& bounds = scene.joint_bounds[primitive.first_joint_bounds + b];
      const scene::Joint& joint = scene.joints[skin.first_joint + bounds.joint];
      add_corners(bounds.bounds_min, bounds.bounds_max, world_from_node[joint.node] * joint.joint_from_mesh,
                  points);
    }
  }
}

// Floors: flat, level, and several times as wide as everything else together. A camera that shows all of a
// floor shows nothing of what stands on it.
std::vector<bool> find_floors(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  constexpr float kFlat = 0.02f, kWide = 3;
  std::vector<bool> is_floor(scene.nodes.size(), false);
  std::vector<std::pair<uint32_t, float>> flat;  // nodes and their widths
  scene::Box others;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == scene::kNone) continue;
    const scene::Box box = scene::bounds_in_world(scene, n, world_from_node);
    if (box.empty() || !is_finite(box.low) || !is_finite(box.high)) continue;
    const glm::vec3 size = box.high - box.low;
    const float width = std::max(size.x, size.z);
    if (size.y <= kFlat * width)
      flat.emplace_back(n, width);
    else
      others.add(box);
  }
  if (others.empty()) return is_floor;
  const glm::vec3 size = others.high - others.low;
  for (const auto& [node, width] : flat) is_floor[node] = width > kWide * std::max({size.x, size.y, size.z});
  return is_floor;
}

}  // namespace

std::vector<glm::vec3> framing_points(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  const std::vector<bool> is_floor = find_floors(scene, world_from_node);
  size_t primitives = 0;
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh != scene::kNone) primitives += scene.meshes[node.mesh].primitive_count;
  }
  // Vertices give a closer fit than boxes. A share of them suffices: the margins are wider than what is
  // missed.
  size_t vertices = 0;
  for (const scene::Node& node : scene.nodes) {
    if (node.mesh == scene::kNone) continue;
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = 0; p < mesh.primitive_count; ++p)
      vertices += scene.primitives[mesh.first_primitive + p].vertex_count;
  }
  const size_t stride = vertices / kMaxPoints + 1;
  std::vector<glm::vec3> points;
  scene::Box all;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    const scene::Node& node = scene.nodes[n];
    if (node.mesh == scene::kNone || is_floor[n]) continue;
    if (primitives > kMaxPrimitives) {
      const scene::Box box = scene::bounds_in_world(scene, n, world_from_node);
      if (!box.empty() && is_finite(box.low) && is_finite(box.high)) all.add(box);
      continue;
    }
    if (node.skin != scene::kNone) {
      add_joint_corners(scene, n, world_from_node, points);
      continue;
    }
    const scene::Mesh& mesh = scene.meshes[node.mesh];
    for (uint32_t p = mesh.first_primitive; p < mesh.first_primitive + mesh.primitive_count; ++p) {
      const scene::Primitive& primitive = scene.primitives[p];
      const bool is_rigid = primitive.morph_target_count == 0 && primitive.vertex_count >= 4 * stride;
      for (size_t v = 0; is_rigid && v < primitive.vertex_count; v += stride) {
        const glm::vec3 world(world_from_node[n] * glm::vec4(scene.positions[primitive.first_vertex + v], 1));
        if (is_finite(world)) points.push_back(world);
      }
      if (is_rigid) continue;
      add_corners(primitive.bounds_min, primitive.bounds_max, world_from_node[n], points);
    }
  }
  if (primitives > kMaxPrimitives && !all.empty()) add_corners(all.low, all.high, glm::mat4(1), points);
  return points;
}

// Each point gives four half-spaces of camera positions that show it. In camera axes with z backwards, a
// point (x, y, z) is inside the right margin of an eye at (ex, ez) if x - ex <= a (ez - z), where a is the
// tangent of the half angle within the margins; the left one mirrors it. Their sum bounds ez, their
// difference gives ex.
glm::mat4 fit_into_view(const scene::Camera& camera, float image_aspect, const glm::mat4& orientation,
                        std::span<const glm::vec3> points) {
  glm::mat4 pose(1);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3 direction(orientation[axis]);
    if (glm::length(direction) > 0) pose[axis] = glm::vec4(glm::normalize(direction), 0);
  }
  if (points.empty()) return pose;
  const double within = 1 - 2 * kFramingMargin;
  const double tangent = std::tan(0.5 * camera.vertical_fov_rad);
  const double a[2] = {within * tangent * std::max(image_aspect, 1e-3f), within * tangent};
  const glm::dmat3 camera_from_world = glm::transpose(glm::dmat3(pose));
  // Relative to one point, so that the result is precise far from the world's origin.
  const glm::dvec3 origin(points.front());
  constexpr double kLowest = std::numeric_limits<double>::lowest();
  double above[2] = {kLowest, kLowest}, below[2] = {kLowest, kLowest}, nearest = kLowest;
  for (const glm::vec3& point : points) {
    const glm::dvec3 p = camera_from_world * (glm::dvec3(point) - origin);
    for (int axis = 0; axis < 2; ++axis) {
      above[axis] = std::max(above[axis], p[axis] + a[axis] * p.z);
      below[axis] = std::max(below[axis], -p[axis] + a[axis] * p.z);
    }
    nearest = std::max(nearest, p.z);
  }
  glm::dvec3 eye(0.5 * (above[0] - below[0]), 0.5 * (above[1] - below[1]), 0);
  eye.z = std::max({(above[0] + below[0]) / (2 * a[0]), (above[1] + below[1]) / (2 * a[1]),
                    nearest + static_cast<double>(camera.near_m)});
  pose[3] = glm::vec4(glm::vec3(origin + glm::dmat3(pose) * eye), 1);
  return pose;
}

glm::mat4 default_orientation() {
  glm::mat4 pose = look_at_pose(glm::vec3(0.6f, 0.45f, 1.0f), glm::vec3(0));
  pose[3] = glm::vec4(0, 0, 0, 1);
  return pose;
}

}  // namespace fire3dv::passes
