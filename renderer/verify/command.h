// Command `fire3dv verify`: draws stored images again and compares them.
#pragma once

#include "renderer/verify/options.h"

namespace fire3dv::verify {

constexpr int kIdentical = 0, kDifferent = 1, kUnchecked = 2;  // exit codes

// Prints the outcome to standard output. Returns the exit code.
int run(const VerifyOptions& options);

}  // namespace fire3dv::verify
