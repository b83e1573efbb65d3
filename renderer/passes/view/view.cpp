#include "renderer/passes/view/view.h"

#include <algorithm>
#include <cmath>

namespace fire3dv::passes {

namespace {

// Principal point in normalised coordinates of the image, whose centre is 0.
glm::vec2 principal_point_ndc(const scene::Camera& camera, float image_aspect) {
  return 2.0f * camera.principal_point / glm::vec2(image_aspect, 1);
}

}  // namespace

glm::mat4 clip_from_camera(const scene::Camera& camera, float image_aspect) {
  const float near = camera.near_m;
  const float far = camera.far_m;
  glm::mat4 m(0);
  if (camera.orthographic) {
    // The file's height is kept; the width follows the image's aspect, so that nothing is stretched.
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
  m[0][0] = focal / (camera.pixel_aspect * image_aspect);
  m[1][1] = -focal;
  if (camera.principal_point != glm::vec2(0)) {
    const glm::vec2 center = principal_point_ndc(camera, image_aspect);
    m[2][0] = -center.x;
    m[2][1] = -center.y;
  }
  if (far > near) {
    m[2][2] = near / (far - near);
    m[3][2] = far * near / (far - near);
  } else {
    m[3][2] = near;
  }
  m[2][3] = -1;
  return m;
}

bool any_lens(const scene::Scene& scene) {
  return std::any_of(scene.cameras.begin(), scene.cameras.end(), [](const scene::Camera& camera) {
    return !camera.orthographic && !camera.lens.is_pinhole();
  });
}

Intrinsics intrinsics_of(const scene::Camera& camera, glm::uvec2 image_px) {
  Intrinsics intrinsics;
  const glm::vec2 size(image_px);
  intrinsics.fy_px = 0.5f * size.y / std::tan(camera.vertical_fov_rad / 2);
  intrinsics.fx_px = intrinsics.fy_px / camera.pixel_aspect;
  intrinsics.cx_px = 0.5f * (size.x - 1) + camera.principal_point.x * size.y;
  intrinsics.cy_px = 0.5f * (size.y - 1) + camera.principal_point.y * size.y;
  intrinsics.image_px = image_px;
  intrinsics.near_m = camera.near_m;
  intrinsics.far_m = camera.far_m;
  return intrinsics;
}

Result<void> check(const Intrinsics& intrinsics) {
  constexpr float kMax = 1e6f;  // focal lengths and principal point, in pixels
  for (const float focal_px : {intrinsics.fx_px, intrinsics.fy_px}) {
    if (!(focal_px >= 1e-3f && focal_px <= kMax))
      return Error{"the camera's fx and fy must be numbers of pixels from 0.001 to 1000000"};
  }
  for (const float place_px : {intrinsics.cx_px, intrinsics.cy_px}) {
    if (!(std::abs(place_px) <= kMax))
      return Error{"the camera's cx and cy must be numbers of pixels between -1000000 and 1000000"};
  }
  if (!(intrinsics.near_m > 0 && std::isfinite(intrinsics.near_m)))
    return Error{"the camera's near distance must be a number of metres above 0"};
  if (!(intrinsics.far_m == 0 || (intrinsics.far_m > intrinsics.near_m && std::isfinite(intrinsics.far_m))))
    return Error{"the camera's far distance must be more than the near one, or 0 for none"};
  if (intrinsics.image_px.x == 0 || intrinsics.image_px.y == 0)
    return Error{"the camera's image must be at least one pixel wide and high"};
  return {};
}

namespace {

// Offset of the image centre from the principal point, in normalised coordinates.
glm::vec2 image_center_ndc(const Intrinsics& intrinsics) {
  return (glm::vec2(intrinsics.cx_px, intrinsics.cy_px) + 0.5f) * 2.0f / glm::vec2(intrinsics.image_px) -
         1.0f;
}

// Camera poses have no scale: only axes and position count, as in glTF.
glm::mat4 without_scale(const glm::mat4& world_from_camera) {
  glm::mat4 rigid(1);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::vec3 direction(world_from_camera[axis]);
    const float length = glm::length(direction);
    if (length > 0) rigid[axis] = glm::vec4(direction / length, 0);
  }
  rigid[3] = glm::vec4(glm::vec3(world_from_camera[3]), 1);
  return rigid;
}

}  // namespace

glm::mat4 clip_from_camera(const Intrinsics& intrinsics) {
  const glm::vec2 size(intrinsics.image_px), image_center = image_center_ndc(intrinsics);
  const float near = intrinsics.near_m, far = intrinsics.far_m;
  glm::mat4 m(0);
  m[0][0] = 2 * intrinsics.fx_px / size.x;
  m[1][1] = -2 * intrinsics.fy_px / size.y;
  m[2][0] = -image_center.x;
  m[2][1] = -image_center.y;
  m[2][2] = far > near ? near / (far - near) : 0;
  m[3][2] = far > near ? far * near / (far - near) : near;
  m[2][3] = -1;
  return m;
}

View make_view(const Intrinsics& intrinsics, const glm::mat4& world_from_camera) {
  const glm::mat4 rigid = without_scale(world_from_camera);
  View view;
  view.eye_world = glm::vec3(rigid[3]);
  view.look_world = -glm::vec3(rigid[2]);
  view.near_m = intrinsics.near_m;
  const glm::vec2 size(intrinsics.image_px), image_center = image_center_ndc(intrinsics);
  view.off_centre = image_center != glm::vec2(0);
  view.world_from_ndc_x = glm::vec3(rigid[0]) * (size.x / (2 * intrinsics.fx_px));
  view.world_from_ndc_y = -glm::vec3(rigid[1]) * (size.y / (2 * intrinsics.fy_px));
  view.world_from_ndc_origin =
      view.look_world - image_center.x * view.world_from_ndc_x - image_center.y * view.world_from_ndc_y;
  view.clip_from_world = clip_from_camera(intrinsics) * glm::inverse(rigid);
  return view;
}

View make_view(const scene::Camera& camera, const glm::mat4& world_from_camera, float image_aspect) {
  View view;
  view.camera = camera.name;
  view.eye_world = glm::vec3(world_from_camera[3]);
  const glm::mat4 rigid = without_scale(world_from_camera);
  view.look_world = -glm::vec3(rigid[2]);
  view.orthographic = camera.orthographic;
  view.near_m = camera.near_m;
  view.exposure = camera.exposure;
  view.lens = camera.lens;
  if (!camera.orthographic) {
    const float focal = 1 / std::tan(camera.vertical_fov_rad / 2);
    view.world_from_ndc_x = glm::vec3(rigid[0]) * (camera.pixel_aspect * image_aspect / focal);
    view.world_from_ndc_y = -glm::vec3(rigid[1]) / focal;
  }
  view.world_from_ndc_origin = -glm::vec3(rigid[2]);
  if (!camera.orthographic && camera.principal_point != glm::vec2(0)) {
    const glm::vec2 center = principal_point_ndc(camera, image_aspect);
    view.off_centre = true;
    view.world_from_ndc_origin -= center.x * view.world_from_ndc_x + center.y * view.world_from_ndc_y;
  }
  view.clip_from_world = clip_from_camera(camera, image_aspect) * glm::inverse(rigid);
  return view;
}

namespace {

// Corners of the near plane are on the rays of the image's corners.
NearWindow perspective_near_window(const View& view) {
  const glm::dvec3 x = double{view.near_m} * glm::dvec3(view.world_from_ndc_x),
                   y = double{view.near_m} * glm::dvec3(view.world_from_ndc_y);
  const glm::dvec3 center =
      glm::dvec3(view.eye_world) + double{view.near_m} * glm::dvec3(view.world_from_ndc_origin);
  NearWindow window;
  window.center_world = center;
  window.radius_m =
      1.001f * static_cast<float>(std::sqrt(std::max(glm::dot(x + y, x + y), glm::dot(x - y, x - y))));
  window.plane_world = glm::vec4(view.look_world, -glm::dot(glm::dvec3(view.look_world), center));
  return window;
}

}  // namespace

NearWindow near_window(const View& view) {
  if (!view.orthographic) return perspective_near_window(view);
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
  // Half a pixel: metres per metre of distance, or metres for an orthographic view.
  float half_pixel = 1 / (static_cast<float>(image_height) * glm::length(y));
  // In an off-centre view, row y leans towards the view direction.
  if (view.off_centre) half_pixel = glm::length(view.world_from_ndc_y) / static_cast<float>(image_height);
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
