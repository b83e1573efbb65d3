// Procedural scenes for frame time benchmarks, and their cameras. Half of the bodies are bumpy spheres, half
// subdivided boxes, on a jittered grid above a ground. Half of each kind have unique meshes; the others share
// eight. A directional light and spot lights light them; the camera shows all bodies during their whole
// motion. Metres, +Y up.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/scene/model/scene.h"
#include "tools/lab/bench/shapes.h"

namespace fire3dv::bench {

struct SceneSize {
  uint64_t triangles = 0;
  uint32_t bodies = 0;  // 0: bodies_for(triangles)
  uint32_t lights = 2;
};

// Returns 200 for 223 K triangles and 1001 for 28 M: proportional to the cube root.
uint32_t bodies_for(uint64_t triangles);

// Rest position and motion of a body.
struct Body {
  glm::vec3 home_m{0};
  float scale = 1;
  glm::vec3 axis{0, 1, 0};
  float angle_rad = 0;  // at step 0
  float phase_rad = 0;  // of the vertical oscillation
};

struct BenchScene {
  scene::Scene scene;
  std::vector<Body> bodies;
  std::vector<std::string> body_names;  // node names of bodies
  uint64_t triangles = 0;               // drawn, with instances
  uint64_t unique_triangles = 0;        // in memory
};

// Equal arguments give identical bytes.
BenchScene make_bench_scene(const SceneSize& size, const Surfaces& surfaces, float image_aspect);

// Computes one pose per body at a simulation step. A body turns about its axis by 0.03 rad per step and
// oscillates vertically, by 0.05 rad per step, between its home and 0.2 m * scale above it.
void pose_bodies(const std::vector<Body>& bodies, uint64_t step,
                 std::vector<wire::Affine3x4>& world_from_body);

// Bounding sphere of a body over its whole motion.
struct Reach {
  glm::vec3 center_m{0};
  float radius_m = 0;
};
Reach reach_of(const Body& body);

constexpr float kCameraFovRad = 0.785398163f;  // vertical

// Returns world_from_camera along a fixed direction, at the smallest distance that shows all bodies during
// their whole motion. It centres their bounds. extent_m: initial guess of the distance.
glm::mat4 camera_pose(const std::vector<Body>& bodies, float extent_m, float image_aspect);

// Cameras on a circle around any scene. aspect: width / height of the images.
std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect);

}  // namespace fire3dv::bench
