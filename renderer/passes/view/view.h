// View of an image: camera transforms and parameters. Depth is reversed; without a far plane it is infinite.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "base/error.h"
#include "renderer/scene/model/ground.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::passes {

struct View {
  uint32_t world = 0;  // that it shows, see SceneRenderer::set_scene()
  std::string camera;  // name, for the image's tag
  glm::mat4 clip_from_world{1};
  glm::vec3 eye_world{0};
  glm::vec3 look_world{0, 0, -1};  // unit
  bool orthographic = false;
  bool off_centre = false;  // the view axis does not pass through the image's centre
  float exposure = 0;       // factor on linear colour; 0: as in the settings
  scene::ThinLens lens;     // of perspective images
  float near_m = 0;
  // Direction of a pixel's ray: x * ndc.x + y * ndc.y + origin, not normalised. It excludes the eye position,
  // so precision does not depend on the distance from the world's origin.
  glm::vec3 world_from_ndc_x{0}, world_from_ndc_y{0}, world_from_ndc_origin{0, 0, -1};
  std::optional<scene::Ground> ground;  // perspective views only; nullopt: none
};

// Lens of an image: that of a stream, else of the settings, else of the camera.
inline const scene::ThinLens& lens_of(const View& view, const scene::ThinLens& settings) {
  return view.lens.of_stream || settings.is_pinhole() ? view.lens : settings;
}
inline bool has_thin_lens(const View& view) {
  return !view.orthographic && !view.lens.is_pinhole();
}

// True if a camera of the scene has a thin lens.
bool any_lens(const scene::Scene& scene);

// Circle around the visible part of the near plane. Geometry between it and the eye is clipped.
struct NearWindow {
  glm::vec3 center_world{0};
  float radius_m = 0;
  glm::vec4 plane_world{0};  // visible side: dot(xyz, p) + w >= 0
};
NearWindow near_window(const View& view);

// Depth change of half a pixel's width, for a surface at depth z: x * z + y.
glm::vec2 half_pixel_depth(const View& view, uint32_t image_height);

// Calibrated pinhole camera: the camera matrix of OpenCV and ROS, in pixels, x to the right and y down. The
// centre of the top left pixel is (0, 0), so a centred camera has cx = (width - 1) / 2.
struct Intrinsics {
  float fx_px = 1, fy_px = 1;
  float cx_px = 0, cy_px = 0;
  glm::uvec2 image_px{1};
  float near_m = 0.01f;
  float far_m = 0;  // 0: infinite
  bool operator==(const Intrinsics&) const = default;
};
// Intrinsics of a scene camera.
Intrinsics intrinsics_of(const scene::Camera& camera, glm::uvec2 image_px);
// Returns an error for invalid intrinsics.
Result<void> check(const Intrinsics& intrinsics);

// Vulkan's clip space: y down, depth 1 at the near plane and 0 at the far one.
glm::mat4 clip_from_camera(const scene::Camera& camera, float image_aspect);
glm::mat4 clip_from_camera(const Intrinsics& intrinsics);
View make_view(const scene::Camera& camera, const glm::mat4& world_from_camera, float image_aspect);
// The pose is a glTF camera's: it looks along -Z, +Y is up in the image.
View make_view(const Intrinsics& intrinsics, const glm::mat4& world_from_camera);

// Pose that frames a whole box, for scenes without a camera.
glm::mat4 framing_camera_pose(const scene::Camera& camera, float image_aspect, const glm::vec3& bounds_min,
                              const glm::vec3& bounds_max);
// world_from_camera of an eye that looks at a target. Up is +Y, unless the view is along it.
glm::mat4 look_at_pose(const glm::vec3& eye, const glm::vec3& target);

}  // namespace fire3dv::passes
