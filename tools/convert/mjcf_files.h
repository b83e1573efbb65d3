// The files that an MJCF model consists of. libmujoco opens them by itself: so they are looked up here first,
// to know what the model depends on, and that none of them is a pipe or a device, which would block.
#pragma once

#include <filesystem>

#include "protocol/error.h"
#include "tools/convert/sources.h"

namespace fire3dv::convert {

// All places where libmujoco may look for files that the model names, the model's own first, then includes.
Result<Sources> mjcf_files(const std::filesystem::path& model);

}  // namespace fire3dv::convert
