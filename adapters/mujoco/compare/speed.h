// How long a step with colour, depth and labels takes, by either renderer: in turns, so that what else the
// machine does hits both.
#pragma once

#include "adapters/mujoco/compare/asked_images.h"
#include "adapters/mujoco/compare/mujoco_renderer.h"

namespace fire3dv::mujoco {

struct Speed {
  double ours_ms = 0, theirs_ms = 0;  // medians of a step with its images
  double ratio = 0;                   // median over turns of theirs / ours
  double lowest = 0, highest = 0;     // of those
};

Result<Speed> measure_speed(Simulation& simulation, AskedImages& ours, MujocoRenderer& theirs, int blocks,
                            int frames);

}  // namespace fire3dv::mujoco
