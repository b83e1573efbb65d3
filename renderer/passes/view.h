// From where an image is taken. Depth is reversed and, for a camera without a far plane, infinite.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "protocol/error.h"
#include "renderer/scene/scene.h"

namespace fire3dv::passes {

struct View {
  std::string camera;  // name, for the image's tag
  glm::mat4 clip_from_world{1};
  glm::vec3 eye_world{0};
  glm::vec3 look_world{0, 0, -1};  // unit
  bool orthographic = false;
  bool off_centre = false;  // the look does not go through the image's middle
  float exposure = 0;       // factor on linear colour; 0 = as the settings say
  float near_m = 0;
  // The ray through a point of the image goes along x * ndc.x + y * ndc.y + origin, not normalised. Without
  // the eye's place, so that it is as exact far from the world's origin as near it.
  glm::vec3 world_from_ndc_x{0}, world_from_ndc_y{0}, world_from_ndc_origin{0, 0, -1};
};

// The piece of the near plane that the image is seen through: what lies between it and the eye is not drawn.
struct NearWindow {
  glm::vec3 center_world{0};
  float radius_m = 0;
  glm::vec4 plane_world{0};  // what is drawn lies where dot(xyz, p) + w >= 0
};
NearWindow near_window(const View& view);

// How far half the width of a pixel is in depth, for a surface at depth z: x * z + y.
glm::vec2 half_pixel_depth(const View& view, uint32_t image_height);

// A pinhole camera as it was calibrated: OpenCV's and ROS' matrix, in pixels, x to the right and y down. The
// middle of the top left pixel is (0, 0), so that a camera in the middle of its image has cx = (width - 1)
// / 2.
struct Intrinsics {
  float fx_px = 1, fy_px = 1;
  float cx_px = 0, cy_px = 0;
  glm::uvec2 image_px{1};
  float near_m = 0.01f;
  float far_m = 0;  // 0 = infinite
  bool operator==(const Intrinsics&) const = default;
};
// Those of a camera of the scene.
Intrinsics intrinsics_of(const scene::Camera& camera, glm::uvec2 image_px);
// One sentence when no image can be taken with them.
Result<void> check(const Intrinsics& intrinsics);

// Vulkan's clip space: y down, depth 1 at the near plane and 0 at the far one.
glm::mat4 clip_from_camera(const scene::Camera& camera, float image_aspect);
glm::mat4 clip_from_camera(const Intrinsics& intrinsics);
View make_view(const scene::Camera& camera, const glm::mat4& world_from_camera, float image_aspect);
// The pose is a glTF camera's: it looks along -Z, +Y is up in the image.
View make_view(const Intrinsics& intrinsics, const glm::mat4& world_from_camera);

// A camera that sees the whole of a box, for scenes that bring none.
glm::mat4 framing_camera_pose(const scene::Camera& camera, float image_aspect, const glm::vec3& bounds_min,
                              const glm::vec3& bounds_max);
// world_from_camera for an eye that looks at a target; up is +Y unless the look is along it.
glm::mat4 look_at_pose(const glm::vec3& eye, const glm::vec3& target);

}  // namespace fire3dv::passes
