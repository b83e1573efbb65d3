// How many images of many cameras a second a running fire3dv sends to a simulator that waits for them in
// lockstep.
#pragma once

#include "protocol/error.h"
#include "tools/bench/cameras_command.h"

namespace fire3dv::bench {

// Prints a table. Asks at options.to, where the scene is shown that the options name.
Result<void> measure_served(const CamerasOptions& options);

}  // namespace fire3dv::bench
