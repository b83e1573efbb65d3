#include "tools/lab/bench/bench_camera.h"

#include <algorithm>
#include <cmath>

#include "renderer/passes/view.h"

namespace fire3dv::bench {
namespace {

// Computes the screen-space bounds of a body, as tangents of view angles. Returns false when it reaches
// behind the camera.
bool extent_in_view(const glm::mat4& camera_from_world, const Reach& reach, glm::vec2& low, glm::vec2& high) {
  const glm::vec3 c(camera_from_world * glm::vec4(reach.center_m, 1));
  if (-c.z <= reach.radius_m) return false;
  for (int axis = 0; axis < 2; ++axis) {
    const float center = std::atan2(c[axis], -c.z);
    const float half = std::asin(std::min(reach.radius_m / std::hypot(c[axis], c.z), 1.0f));
    if (std::abs(center) + half > 1.5f) return false;
    low[axis] = std::tan(center - half);
    high[axis] = std::tan(center + half);
  }
  return true;
}

// Computes the screen-space bounds of all bodies.
bool extent_in_view(const glm::mat4& world_from_camera, const std::vector<Body>& bodies, glm::vec2& low,
                    glm::vec2& high) {
  const glm::mat4 camera_from_world = glm::inverse(world_from_camera);
  low = glm::vec2(1e9f);
  high = glm::vec2(-1e9f);
  for (const Body& body : bodies) {
    glm::vec2 body_low, body_high;
    if (!extent_in_view(camera_from_world, reach_of(body), body_low, body_high)) return false;
    low = glm::min(low, body_low);
    high = glm::max(high, body_high);
  }
  return true;
}

}  // namespace

glm::mat4 camera_pose(const std::vector<Body>& bodies, float extent_m, float image_aspect) {
  const glm::vec3 towards = glm::normalize(glm::vec3(0.35f, 0.75f, 1));
  const float tan_y = std::tan(kCameraFovRad / 2) * 0.98f;
  const glm::vec2 most(tan_y * image_aspect, tan_y);
  glm::vec3 target(0);
  const auto pose = [&](float distance) { return passes::look_at_pose(target + towards * distance, target); };
  glm::vec2 low, high;
  const auto sees_all = [&](float distance) {
    return extent_in_view(pose(distance), bodies, low, high) && glm::all(glm::greaterThanEqual(low, -most)) &&
           glm::all(glm::lessThanEqual(high, most));
  };
  float distance = 0;
  for (int round = 0; round < 8; ++round) {
    float near = 0, far = extent_m + 10;
    // A very narrow image needs a distance that exceeds float precision.
    for (int i = 0; i < 20 && !sees_all(far); ++i) far *= 2;
    for (int i = 0; i < 24; ++i) {
      const float center = (near + far) / 2;
      (sees_all(center) ? far : near) = center;
    }
    distance = far;
    if (round == 7 || !sees_all(distance)) break;  // the last distance fits the last target
    const glm::vec2 off_center = (low + high) * 0.5f;
    const glm::mat4 axes = pose(distance);
    target += distance * (off_center.x * glm::vec3(axes[0]) + off_center.y * glm::vec3(axes[1]));
  }
  return pose(distance);
}

std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect) {
  std::vector<glm::mat4> world_from_camera;
  const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
  const glm::mat4 first =
      passes::framing_camera_pose(scene::Camera(), aspect, scene.bounds_min, scene.bounds_max);
  const glm::vec3 from = glm::vec3(first[3]) - center;
  for (uint32_t i = 0; i < count; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(count);
    const float c = std::cos(angle), s = std::sin(angle);
    const glm::vec3 turned(c * from.x + s * from.z, from.y, c * from.z - s * from.x);
    world_from_camera.push_back(passes::look_at_pose(center + turned, center));
  }
  return world_from_camera;
}

}  // namespace fire3dv::bench
