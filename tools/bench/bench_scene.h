// The scenes that frame times are measured on. Half of the bodies are bumpy spheres and half subdivided
// boxes, on a jittered grid above a ground, under a directional light and spot lights, before a camera that
// sees all bodies wherever they move. Of either kind half have a mesh of their own; the others share eight.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/scene/scene.h"
#include "tools/bench/surfaces.h"

namespace fire3dv::bench {

struct SceneSize {
  uint64_t triangles = 0;
  uint32_t bodies = 0;  // 0: as many as bodies_for says
  uint32_t lights = 2;
};

// 200 at 223 K triangles, 1001 at 28 M: with the cube root of the triangles.
uint32_t bodies_for(uint64_t triangles);

// Where a body is, and how it moves.
struct Body {
  glm::vec3 home_m{0};
  float scale = 1;
  glm::vec3 axis{0, 1, 0};
  float angle_rad = 0;  // at step 0
  float phase_rad = 0;  // of its rise and fall
};

struct BenchScene {
  scene::Scene scene;
  std::vector<Body> bodies;
  std::vector<std::string> body_names;  // of their nodes
  uint64_t triangles = 0;               // drawn, those of instances too
  uint64_t unique_triangles = 0;        // in memory
};

// The same arguments give the same bytes.
BenchScene make_bench_scene(const SceneSize& size, const Surfaces& surfaces, float image_aspect);

// Where all bodies are at a step of the simulation; they turn and rise and fall. As many as bodies.
void pose_bodies(const std::vector<Body>& bodies, uint64_t step,
                 std::vector<wire::Affine3x4>& world_from_body);

// The ball that a body never leaves.
struct Reach {
  glm::vec3 center_m{0};
  float radius_m = 0;
};
Reach reach_of(const Body& body);

}  // namespace fire3dv::bench
