// Command `fire3dv relabel`: import of a recording of another program, and a data set of it.
#pragma once

#include "renderer/relabel/options.h"

namespace fire3dv::relabel {

// Returns the exit code.
int run(const RelabelOptions& options);

}  // namespace fire3dv::relabel
