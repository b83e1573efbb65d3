// Main function of the renderer after option parsing.
#pragma once

#include "renderer/app/options/options.h"

namespace fire3dv::app {

// Returns the exit code: 0, or 1 after a printed error.
int run(const Options& options);

}  // namespace fire3dv::app
