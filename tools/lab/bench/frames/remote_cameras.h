// Throughput of a running fire3dv that sends images of many cameras to a lockstep client.
#pragma once

#include "protocol/base/error.h"
#include "tools/lab/bench/frames/cameras_command.h"

namespace fire3dv::bench {

// Prints a table. Connects to options.to, which must show the scene that the options name.
Result<void> measure_served(const CamerasOptions& options);

}  // namespace fire3dv::bench
