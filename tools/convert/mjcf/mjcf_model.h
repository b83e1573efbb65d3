// Conversion of a compiled MuJoCo model to a Model.
#pragma once

#include <mujoco/mujoco.h>

#include "tools/convert/model.h"
#include "tools/convert/readers.h"

namespace fire3dv::convert {

// Adds bodies, cameras, lights and tendons, named as in MjcfNames, in the pose of `posed`. Their poses must
// have been computed (pose_mjcf, mj_forward or more).
void add_mjcf(const mjModel& compiled, const mjData& posed, const ReadOptions& options, Model& model);

}  // namespace fire3dv::convert
