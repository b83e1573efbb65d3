// Check of a file that is written under its final name: somebody may remove or replace it meanwhile.
#pragma once

#include <string>

#include "base/error.h"

namespace fire3dv::record {

// Fails if `path` no longer names the open file: it was removed, moved or replaced. Two system calls.
Result<void> check_name_of(int fd, const std::string& path);

}  // namespace fire3dv::record
