// A compiled MuJoCo model as what is written as glTF.
#pragma once

#include <mujoco/mujoco.h>

#include "tools/convert/model.h"
#include "tools/convert/readers.h"

namespace fire3dv::convert {

// Adds bodies, cameras, lights and tendons, called as MjcfNames has them, where `posed` has them: bodies,
// cameras, lights and tendons must have been computed (pose_mjcf, mj_forward or more).
void add_mjcf(const mjModel& compiled, const mjData& posed, const ReadOptions& options, Model& model);

}  // namespace fire3dv::convert
