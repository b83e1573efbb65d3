// Steps the model and publishes it, at the pace that was asked for.
#pragma once

#include "adapters/mujoco/options.h"

namespace fire3dv::mujoco {

// Ends in order on SIGINT, SIGTERM and SIGHUP.
Result<void> run(const Options& options);

}  // namespace fire3dv::mujoco
