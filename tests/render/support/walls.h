// A camera at the origin before a wall, of tests that compare light with closed forms.
#pragma once

#include <cmath>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {

// A camera at the origin that looks along -Z, with 1 rad of height.
inline SceneBuilder camera_at_origin(float fov_rad = 1) {
  SceneBuilder builder;
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1}, fov_rad);
  return builder;
}

// Stands up a quad: from the XZ plane, facing +Y, to facing +Z.
inline glm::mat4 wall_at(float distance_m, glm::vec2 place = glm::vec2(0)) {
  glm::mat4 pose(1);
  pose[1] = {0, 0, 1, 0};
  pose[2] = {0, -1, 0, 0};
  pose[3] = {place.x, place.y, -distance_m, 1};
  return pose;
}

inline scene::Scene wall(const scene::Material& material, float distance_m = 0.05f, float fov_rad = 1) {
  SceneBuilder builder = camera_at_origin(fov_rad);
  builder.mesh_node("wall", builder.quad(builder.material(material), 4), wall_at(distance_m));
  return builder.build();
}

// Point of a wall at a pixel's centre.
inline glm::dvec3 point_at(glm::uvec2 pixel, VkExtent2D extent, double distance_m, double fov_rad) {
  const double scale = 2 * distance_m * std::tan(fov_rad / 2) / extent.height;
  return {(pixel.x + 0.5 - 0.5 * extent.width) * scale, (0.5 * extent.height - pixel.y - 0.5) * scale,
          -distance_m};
}

inline sinks::FrameImage drawn(const scene::Scene& scene, const settings::DrawSettings& settings,
                               VkExtent2D extent) {
  return RenderBench(scene, extent, settings).draw_at_rest();
}

}  // namespace fire3dv::test
