// The option --drake: starts fire3dv-drake, the render server for Drake, in place of this program. The server
// is a program of its own, so that the renderer links no HTTP library.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::app {

// Arguments of fire3dv-drake if the command line holds --drake, else nullopt: the address first, then all
// other arguments in their order.
std::optional<std::vector<std::string>> drake_arguments(int argc, const char* const* argv);

// Executes the fire3dv-drake beside this program's executable. Returns only with an error: this build or
// installation has none.
Error execute_drake(const std::vector<std::string>& arguments);

}  // namespace fire3dv::app
