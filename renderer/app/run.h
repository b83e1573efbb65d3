// The renderer from its options to its end.
#pragma once

#include "renderer/app/options.h"

namespace fire3dv::app {

// Returns the exit code: 0, or 1 after an error that was printed.
int run(const Options& options);

}  // namespace fire3dv::app
