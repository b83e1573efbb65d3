#include "renderer/passes/view/framing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/scene/model/surface_area.h"

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

struct NodeBox {
  uint32_t node;
  scene::Box world;
  double area_m2;  // of the mesh's surface

  glm::vec3 size() const { return world.high - world.low; }
};

std::vector<NodeBox> boxes_of_meshes(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  std::vector<NodeBox> boxes;
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh == scene::kNone || scene::is_unbounded(scene, n)) continue;
    const scene::Box box = scene::bounds_in_world(scene, n, world_from_node);
    if (!box.empty() && is_finite(box.low) && is_finite(box.high))
      boxes.push_back({n, box, scene::surface_area(scene, scene.nodes[n], world_from_node[n])});
  }
  return boxes;
}

// Floors: flat, level, and several times as wide as everything else together. A camera that shows all of a
// floor shows nothing of what stands on it.
void leave_out_floors(std::vector<NodeBox>& boxes) {
  constexpr float kFlat = 0.02f, kWide = 3;
  const auto width_of = [](const NodeBox& box) { return std::max(box.size().x, box.size().z); };
  const auto is_flat = [&](const NodeBox& box) { return box.size().y <= kFlat * width_of(box); };
  scene::Box others;
  for (const NodeBox& box : boxes) {
    if (!is_flat(box)) others.add(box.world);
  }
  if (others.empty()) return;
  const glm::vec3 size = others.high - others.low;
  const float widest = kWide * std::max({size.x, size.y, size.z});
  std::erase_if(boxes, [&](const NodeBox& box) { return is_flat(box) && width_of(box) > widest; });
}

// Meshes so far away that their vertices fall together in 32 bits, such as by a damaged transform, if others
// are sound. They show nothing.
void leave_out_collapsed(std::vector<NodeBox>& boxes) {
  constexpr float kTooFar = 1e6f;  // in sizes of the mesh
  const auto is_collapsed = [](const NodeBox& box) {
    return glm::length(box.world.low + box.world.high) / 2 > kTooFar * glm::length(box.size());
  };
  if (!std::all_of(boxes.begin(), boxes.end(), is_collapsed)) std::erase_if(boxes, is_collapsed);
}

// Outliers: a few small or thin meshes, such as a tool that is parked far away or the axes of a motion
// capture marker, without which everything else is shown at least 1.4 times as large. Removes, again and
// again, the mesh whose absence shrinks the bounding box most.
void leave_out_outliers(std::vector<NodeBox>& boxes) {
  constexpr double kMaxAreaShare = 0.05;
  constexpr float kMaxNodeShare = 0.34f, kMinGain = 1.4f;
  constexpr size_t kMaxRemoved = 32;
  const auto diagonal_of = [](const std::vector<NodeBox>& of, size_t without) {
    scene::Box box;
    for (size_t i = 0; i < of.size(); ++i) {
      if (i != without) box.add(of[i].world);
    }
    return box.empty() ? 0.0f : glm::length(box.high - box.low);
  };
  const size_t max_removed =
      std::min(kMaxRemoved, static_cast<size_t>(kMaxNodeShare * static_cast<float>(boxes.size())));
  std::vector<NodeBox> rest = boxes, best;
  double area = 0, removed_area = 0;
  for (const NodeBox& box : boxes) area += box.area_m2;
  const float whole = diagonal_of(boxes, boxes.size());
  float wanted = whole / kMinGain;
  for (size_t removed = 0; removed < max_removed; ++removed) {
    // Only meshes at a side of the bounding box can shrink it.
    std::vector<size_t> at_sides;
    for (int axis = 0; axis < 3; ++axis) {
      const auto lower = [axis](const NodeBox& a, const NodeBox& b) {
        return a.world.low[axis] < b.world.low[axis];
      };
      const auto higher = [axis](const NodeBox& a, const NodeBox& b) {
        return a.world.high[axis] < b.world.high[axis];
      };
      at_sides.push_back(
          static_cast<size_t>(std::min_element(rest.begin(), rest.end(), lower) - rest.begin()));
      at_sides.push_back(
          static_cast<size_t>(std::max_element(rest.begin(), rest.end(), higher) - rest.begin()));
    }
    size_t chosen = rest.size();
    float smallest = std::numeric_limits<float>::max();
    for (const size_t candidate : at_sides) {
      if (removed_area + rest[candidate].area_m2 > kMaxAreaShare * area) continue;
      const float diagonal = diagonal_of(rest, candidate);
      if (diagonal < smallest) smallest = diagonal, chosen = candidate;
    }
    if (chosen == rest.size()) break;
    removed_area += rest[chosen].area_m2;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(chosen));
    if (smallest > wanted) continue;
    best = rest;
    wanted = 0.9f * smallest;  // further meshes are left out only for a further gain
  }
  if (!best.empty()) boxes = std::move(best);
}

// Marks the nodes that the default view need not show.
std::vector<bool> find_left_out(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  std::vector<NodeBox> boxes = boxes_of_meshes(scene, world_from_node);
  std::vector<bool> is_left_out(scene.nodes.size(), false);
  for (uint32_t n = 0; n < scene.nodes.size(); ++n) is_left_out[n] = scene::is_unbounded(scene, n);
  for (const NodeBox& box : boxes) is_left_out[box.node] = true;
  leave_out_collapsed(boxes);
  leave_out_floors(boxes);
  leave_out_outliers(boxes);
  for (const NodeBox& box : boxes) is_left_out[box.node] = false;
  return is_left_out;
}

}  // namespace

scene::Box bounds_without_outliers(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  std::vector<NodeBox> boxes = boxes_of_meshes(scene, world_from_node);
  leave_out_collapsed(boxes);
  const std::vector<NodeBox> all = boxes;
  leave_out_floors(boxes);
  std::vector<NodeBox> subject = boxes;
  leave_out_outliers(subject);
  scene::Box bounds;
  for (const NodeBox& box : subject) bounds.add(box.world);
  const auto is_among = [](const std::vector<NodeBox>& of, uint32_t node) {
    return std::binary_search(of.begin(), of.end(), NodeBox{node, {}, 0},
                              [](const NodeBox& a, const NodeBox& b) { return a.node < b.node; });
  };
  for (const NodeBox& box : all) {
    if (!is_among(boxes, box.node)) bounds.add(box.world);  // a floor
  }
  return bounds;
}

std::vector<glm::vec3> framing_points(const scene::Scene& scene, std::span<const glm::mat4> world_from_node) {
  const std::vector<bool> is_left_out = find_left_out(scene, world_from_node);
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
    if (node.mesh == scene::kNone || is_left_out[n]) continue;
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

namespace {

// Position of the eye along an axis of the image, within `slack` of eye[axis], that leaves equally wide
// borders on both sides. In camera axes relative to origin.
double centred(int axis, const glm::dvec3& eye, double slack, const glm::dmat3& camera_from_world,
               const glm::dvec3& origin, std::span<const glm::vec3> points) {
  double low = eye[axis] - slack, high = eye[axis] + slack;
  for (int step = 0; step < 16; ++step) {
    const double middle = 0.5 * (low + high);
    double least = std::numeric_limits<double>::max(), most = std::numeric_limits<double>::lowest();
    for (const glm::vec3& point : points) {
      const glm::dvec3 p = camera_from_world * (glm::dvec3(point) - origin);
      const double at = (p[axis] - middle) / (eye.z - p.z);
      least = std::min(least, at);
      most = std::max(most, at);
    }
    (least + most > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

// Each point gives four half-spaces of camera positions that show it. In camera axes with z backwards, a
// point (x, y, z) is inside the right margin of an eye at (ex, ez) if x - ex <= a (ez - z), where a is the
// tangent of the half angle within the margins; the left one mirrors it. The sum of a right and a left one
// bounds ez; at that ez they bound ex.
glm::mat4 fit_into_view(const scene::Camera& camera, float image_aspect, const glm::mat4& orientation,
                        std::span<const glm::vec3> points, std::span<const glm::vec3> to_border) {
  glm::mat4 pose(1);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3 direction(orientation[axis]);
    if (glm::length(direction) > 0) pose[axis] = glm::vec4(glm::normalize(direction), 0);
  }
  if (points.empty()) return pose;
  const glm::dmat3 camera_from_world = glm::transpose(glm::dmat3(pose));
  // Relative to one point, so that the result is precise far from the world's origin.
  const glm::dvec3 origin(points.front());
  const double tangent = std::tan(0.5 * camera.vertical_fov_rad);
  const glm::dvec2 whole(tangent * std::max(image_aspect, 1e-3f), tangent);
  constexpr double kLowest = std::numeric_limits<double>::lowest();
  struct Bounds {
    glm::dvec2 a;  // by axis, as below
    glm::dvec2 right{kLowest}, left{kLowest};
  };
  constexpr double kBorder = 0.02;  // share of the image's half width or height
  Bounds all[2] = {{(1 - 2.0 * kFramingMargin) * whole}, {(1 - kBorder) * whole}};
  double nearest = kLowest;
  const auto add = [&](const glm::vec3& point, Bounds& bounds) {
    const glm::dvec3 p = camera_from_world * (glm::dvec3(point) - origin);
    bounds.right = glm::max(bounds.right, glm::dvec2(p) + bounds.a * p.z);
    bounds.left = glm::max(bounds.left, -glm::dvec2(p) + bounds.a * p.z);
    return p.z;
  };
  for (const glm::vec3& point : points) nearest = std::max(nearest, add(point, all[0]));
  for (const glm::vec3& point : to_border) add(point, all[1]);
  glm::dvec3 eye(0, 0, nearest + static_cast<double>(camera.near_m));
  for (const Bounds& right : all)
    for (const Bounds& left : all)
      for (int axis = 0; axis < 2; ++axis)
        eye.z = std::max(eye.z, (right.right[axis] + left.left[axis]) / (right.a[axis] + left.a[axis]));
  std::vector<glm::vec3> shown(points.begin(), points.end());
  shown.insert(shown.end(), to_border.begin(), to_border.end());
  for (int axis = 0; axis < 2; ++axis) {
    double low = kLowest, high = -kLowest;
    for (const Bounds& bounds : all) {
      low = std::max(low, bounds.right[axis] - bounds.a[axis] * eye.z);
      high = std::min(high, bounds.a[axis] * eye.z - bounds.left[axis]);
    }
    eye[axis] = 0.5 * (low + high);
    const double slack = 0.5 * (high - low);
    if (slack > 0) eye[axis] = centred(axis, eye, slack, camera_from_world, origin, shown);
  }
  pose[3] = glm::vec4(glm::vec3(origin + glm::dmat3(pose) * eye), 1);
  return pose;
}

bool shows_all(const scene::Camera& camera, float image_aspect, const glm::mat4& world_from_camera,
               std::span<const glm::vec3> points) {
  const glm::dmat3 camera_from_world = glm::transpose(glm::dmat3(world_from_camera));
  const glm::dvec3 eye(world_from_camera[3]);
  const double up = std::tan(0.5 * camera.vertical_fov_rad), right = up * image_aspect;
  return std::all_of(points.begin(), points.end(), [&](const glm::vec3& point) {
    const glm::dvec3 p = camera_from_world * (glm::dvec3(point) - eye);
    return p.z < 0 && std::abs(p.x) <= -right * p.z && std::abs(p.y) <= -up * p.z;
  });
}

std::vector<glm::vec3> shadows_on_ground(std::span<const glm::vec3> points, float height_m,
                                         const glm::vec4& light) {
  std::vector<glm::vec3> shadows;
  for (const glm::vec3& point : points) {
    const float above_m = point.y - height_m;
    const glm::vec3 to_light = glm::vec3(light) - light.w * point;
    if (above_m > 0 && to_light.y > 0) shadows.push_back(point - to_light * (above_m / to_light.y));
  }
  return shadows;
}

std::vector<std::vector<glm::vec3>> ground_shadows(const scene::Scene& scene,
                                                   std::span<const glm::vec3> points, float height_m) {
  std::vector<std::vector<glm::vec3>> shadows;
  for (const scene::PlacedLight& placed : scene::lights_of(scene, nullptr)) {
    if (!placed.light.casts_shadow || placed.light.intensity <= 0) continue;
    const glm::mat4& pose = scene.nodes[placed.node].world_from_node;
    const bool is_lamp = placed.light.type != scene::LightType::directional;
    shadows.push_back(
        shadows_on_ground(points, height_m, is_lamp ? pose[3] : glm::vec4(glm::vec3(pose[2]), 0)));
  }
  return shadows;
}

glm::mat4 default_orientation() {
  glm::mat4 pose = look_at_pose(glm::vec3(0.6f, 0.45f, 1.0f), glm::vec3(0));
  pose[3] = glm::vec4(0, 0, 0, 1);
  return pose;
}

}  // namespace fire3dv::passes
