// Time of a step with colour, depth and labels in both renderers. Blocks alternate, so that other load on the
// machine affects both.
#pragma once

#include "adapters/mujoco/compare/image_client.h"
#include "adapters/mujoco/compare/mujoco_renderer.h"

namespace fire3dv::mujoco {

struct Speed {
  double ours_ms = 0, theirs_ms = 0;  // median of a step with its images
  double ratio = 0;                   // median over blocks of theirs / ours
  double lowest = 0, highest = 0;     // range of these ratios
};

Result<Speed> measure_speed(Simulation& simulation, RequestedImages& ours, MujocoRenderer& theirs, int blocks,
                            int frames);

}  // namespace fire3dv::mujoco
