// Main loop of fire3dv-mujoco: steps the model at the requested pace and publishes it.
#pragma once

#include "adapters/mujoco/options.h"

namespace fire3dv::mujoco {

// Returns after SIGINT, SIGTERM or SIGHUP, with streams closed in order.
Result<void> run(const Options& options);

}  // namespace fire3dv::mujoco
