// The visible part of the near plane, against the corners of clip space.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "renderer/passes/view/view.h"

namespace fire3dv::passes {
namespace {

constexpr float kAspect = 1.5f;

View view_of(const scene::Camera& camera) {
  const glm::mat4 world_from_camera = glm::rotate(glm::translate(glm::mat4(1), glm::vec3(3, -2, 5)), 0.7f,
                                                  glm::normalize(glm::vec3(1, 2, 3)));
  return make_view(camera, world_from_camera, kAspect);
}

void expect_corners_of_clip_space(const View& view) {
  const NearWindow window = near_window(view);
  const glm::dmat4 world_from_clip = glm::inverse(glm::dmat4(view.clip_from_world));
  glm::dvec3 middle(0);
  double farthest_m = 0;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const glm::dvec4 corner = world_from_clip * glm::dvec4(x, y, 1, 1);
      const glm::dvec3 world = glm::dvec3(corner) / corner.w;
      middle += 0.25 * world;
      farthest_m = std::max(farthest_m, glm::distance(world, glm::dvec3(window.center_world)));
      EXPECT_NEAR(glm::dot(glm::dvec3(window.plane_world), world) + window.plane_world.w, 0, 2e-6);
    }
  }
  EXPECT_NEAR(glm::distance(middle, glm::dvec3(window.center_world)), 0, 2e-6);
  EXPECT_GE(window.radius_m, farthest_m);
  EXPECT_LE(window.radius_m, 1.01 * farthest_m);
}

TEST(NearWindow, OfACentredCamera) {
  scene::Camera camera;
  camera.near_m = 0.05f;
  camera.vertical_fov_rad = 0.9f;
  camera.pixel_aspect = 1.1f;
  expect_corners_of_clip_space(view_of(camera));
}

TEST(NearWindow, OfAnOffCentreCameraWithAFarPlane) {
  scene::Camera camera;
  camera.near_m = 0.2f;
  camera.far_m = 7;
  camera.principal_point = glm::vec2(0.3f, -0.2f);
  expect_corners_of_clip_space(view_of(camera));
}

TEST(NearWindow, OfACalibratedCamera) {
  const Intrinsics intrinsics{500, 450, 300, 250, {640, 480}, 0.1f, 0};
  expect_corners_of_clip_space(make_view(intrinsics, glm::translate(glm::mat4(1), glm::vec3(-1, 4, 2))));
}

TEST(NearWindow, OfAnOrthographicCamera) {
  scene::Camera camera;
  camera.orthographic = true;
  camera.near_m = 0.1f;
  camera.far_m = 10;
  camera.half_extent_m = glm::vec2(0.6f, 0.4f);
  expect_corners_of_clip_space(view_of(camera));
}

}  // namespace
}  // namespace fire3dv::passes
