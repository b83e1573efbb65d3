// Scenes with reference images by Blender's Cycles: surfaces whose models agree (Lambert, GGX metals, smooth
// glass). docs/truth.md says how the images were made.
#pragma once

#include <vector>

#include "examples/gallery/scenes.h"

namespace gallery {

// plane_point, plane_sun, ball_point, metal_ball, room, environment_balls: goldens of the tests; spheres,
// glass (and room): docs/gallery.md. Matte materials have specularFactor 0; the first camera is the one of
// the images.
std::vector<SceneFile> make_reference_scenes();

// Geometry of ball_point and metal_ball.
struct BallView {
  float radius_m = 0.5f;  // about the origin
  float light_m[3] = {1.2f, 1.5f, 2.0f};
  float light_cd = 10;
  float eye_m[3] = {0, 0.3f, 3};  // looks at the origin, Y up
  float vertical_fov_rad = 0.42f;
  float metal_roughness = 0.5f;
};

}  // namespace gallery
