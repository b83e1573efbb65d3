// Where the benchmark's scenes are seen from.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "tools/bench/bench_scene.h"

namespace fire3dv::bench {

constexpr float kCameraFovRad = 0.785398163f;  // vertical

// Along one direction, as near as all bodies can be seen from wherever they move, and aimed so that they fill
// the picture's middle. extent_m: a first guess of the distance.
glm::mat4 camera_pose(const std::vector<Body>& bodies, float extent_m, float image_aspect);

}  // namespace fire3dv::bench
