// The files that an MJCF model consists of. libmujoco opens them by itself: so they are looked up here first,
// to know what the model depends on, that none of them is a pipe or a device, which would block, and that
// none lies where the user has not said that the model may read.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/sources.h"

namespace fire3dv::convert {

// All places where libmujoco may look for files that the model names, the model's own first, then includes.
// An error where one of them is there and lies, links resolved, neither below the model's folder nor below
// one of `folders`.
Result<Sources> mjcf_files(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& folders = {});

}  // namespace fire3dv::convert
