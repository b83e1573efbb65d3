// Camera poses of benchmarks: the camera of the generated scene, and cameras on a circle around any scene.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderer/scene/model/scene.h"
#include "tools/lab/bench/bench_scene.h"

namespace fire3dv::bench {

constexpr float kCameraFovRad = 0.785398163f;  // vertical

// Returns world_from_camera along a fixed direction, at the smallest distance that shows all bodies during
// their whole motion. It centres their bounds. extent_m: initial guess of the distance.
glm::mat4 camera_pose(const std::vector<Body>& bodies, float extent_m, float image_aspect);

// aspect: width / height of the images.
std::vector<glm::mat4> circle_of_cameras(const scene::Scene& scene, uint32_t count, float aspect);

}  // namespace fire3dv::bench
