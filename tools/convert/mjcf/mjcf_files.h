// File references of an MJCF model, resolved before libmujoco opens them itself. Detects dependencies,
// refuses pipes and devices, which would block, and refuses files outside the allowed folders.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/sources.h"

namespace fire3dv::convert {

// Returns all paths where libmujoco may look for files: the model, its includes, then others. Fails where an
// existing one lies, with links resolved, outside the model's folder and `folders`.
Result<Sources> mjcf_files(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& folders = {});

}  // namespace fire3dv::convert
