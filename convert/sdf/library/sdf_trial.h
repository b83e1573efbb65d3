// Trial run of a function in a process of its own, for libraries that crash on damaged files.
#pragma once

#include <functional>

#include "base/error.h"

namespace fire3dv::convert {

// Forks and calls the function there, with limits on time and memory and without output. Exceptions are no
// failure. The error says how the process ended.
Result<void> try_in_process(const std::function<void()>& function);

}  // namespace fire3dv::convert
