#include "renderer/passes/view.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::passes {

glm::mat4 clip_from_camera(const scene::Camera& camera, float image_aspect) {
  const float near = camera.near_m;
  const float far = camera.far_m;
  glm::mat4 m(0);
  if (camera.orthographic) {
    // The file's extent is kept in height; the width follows the image, so that nothing is stretched.
    const float half_height = camera.half_extent_m.y;
    const float far_plane = far > near ? far : near + 1e4f;
    m[0][0] = 1 / (half_height * image_aspect);
    m[1][1] = -1 / half_height;
    m[2][2] = 1 / (far_plane - near);
    m[3][2] = far_plane / (far_plane - near);
    m[3][3] = 1;
    return m;
  }
  const float focal = 1 / std::tan(camera.vertical_fov_rad / 2);
  m[0][0] = focal / image_aspect;
  m[1][1] = -focal;
  if (far > near) {
    m[2][2] = near / (far - near);
    m[3][2] = far * near / (far - near);
  } else {
    m[3][2] = near;
  }
  m[2][3] = -1;
  return m;
}

View make_view(const scene::Camera& camera, const glm::mat4& world_from_camera, float image_aspect) {
  View view;
  view.camera = camera.name;
  view.eye_world = glm::vec3(world_from_camera[3]);
  // A camera's pose has no scale: only its axes and place count, as glTF says.
  glm::mat4 rigid(1);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3 direction(world_from_camera[axis]);
    const float length = glm::length(direction);
    if (length > 0) rigid[axis] = glm::vec4(direction / length, 0);
  }
  rigid[3] = glm::vec4(view.eye_world, 1);
  view.look_world = -glm::vec3(rigid[2]);
  view.orthographic = camera.orthographic;
  view.exposure = camera.exposure;
  if (!camera.orthographic) {
    const float focal = 1 / std::tan(camera.vertical_fov_rad / 2);
    view.world_from_ndc_x = glm::vec3(rigid[0]) * (image_aspect / focal);
    view.world_from_ndc_y = -glm::vec3(rigid[1]) / focal;
  }
  view.world_from_ndc_origin = -glm::vec3(rigid[2]);
  view.clip_from_world = clip_from_camera(camera, image_aspect) * glm::inverse(rigid);
  return view;
}

NearWindow near_window(const View& view) {
  const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4(view.clip_from_world));
  glm::dvec3 corners[4];
  for (int i = 0; i < 4; ++i) {
    const glm::dvec4 corner = world_from_clip * glm::dvec4(i & 1 ? 1 : -1, i & 2 ? 1 : -1, 1, 1);
    corners[i] = glm::dvec3(corner) / corner.w;
  }
  const glm::dvec3 center = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  NearWindow window;
  window.center_world = center;
  for (const glm::dvec3& corner : corners) {
    window.radius_m = std::max(window.radius_m, 1.001f * static_cast<float>(glm::distance(corner, center)));
  }
  window.plane_world = glm::vec4(view.look_world, -glm::dot(glm::dvec3(view.look_world), center));
  return window;
}

glm::vec2 half_pixel_depth(const View& view, uint32_t image_height) {
  const glm::mat4 rows = glm::transpose(view.clip_from_world);
  const glm::vec3 y(rows[1]), z(rows[2]), w(rows[3]);
  // Half a pixel, in metres for each metre of distance; or in metres.
  const float half_pixel = 1 / (static_cast<float>(image_height) * glm::length(y));
  if (view.orthographic) return {0, half_pixel * glm::length(z)};
  // z / w = b / w - a: a step dw in distance changes it by (z / w + a) dw / w.
  const float a = -glm::dot(z, w) / glm::dot(w, w);
  return {half_pixel, half_pixel * a};
}

glm::mat4 look_at_pose(const glm::vec3& eye, const glm::vec3& target) {
  const glm::vec3 back = glm::normalize(eye - target);
  const glm::vec3 up = std::abs(back.y) > 0.999f ? glm::vec3(0, 0, back.y > 0 ? -1 : 1) : glm::vec3(0, 1, 0);
  const glm::vec3 right = glm::normalize(glm::cross(up, back));
  glm::mat4 pose(1);
  pose[0] = glm::vec4(right, 0);
  pose[1] = glm::vec4(glm::cross(back, right), 0);
  pose[2] = glm::vec4(back, 0);
  pose[3] = glm::vec4(eye, 1);
  return pose;
}

glm::mat4 framing_camera_pose(const scene::Camera& camera, float image_aspect, const glm::vec3& bounds_min,
                              const glm::vec3& bounds_max) {
  const glm::vec3 center = 0.5f * (bounds_min + bounds_max);
  const float radius = std::max(0.5f * glm::length(bounds_max - bounds_min), 1e-4f);
  const float half_fov = camera.vertical_fov_rad / 2;
  const float half_fov_x = std::atan(std::tan(half_fov) * image_aspect);
  const float distance = radius / std::sin(std::min(half_fov, half_fov_x));
  return look_at_pose(center + distance * glm::normalize(glm::vec3(0.6f, 0.45f, 1.0f)), center);
}

}  // namespace fire3dv::passes
