// Command `fire3dv dataset`, and its part of `fire3dv join`.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/error.h"
#include "renderer/dataset/options.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::dataset {

// Draws a data set. Returns the exit code.
int run(const DatasetOptions& options);

}  // namespace fire3dv::dataset
