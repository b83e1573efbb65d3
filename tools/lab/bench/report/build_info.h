// Build information of fire3dv-bench, generated at build time by commit.cmake.
#pragma once

namespace fire3dv::bench {

// Commit of this build, from `git describe`; "unknown" outside a git checkout.
extern const char* const kCommit;

}  // namespace fire3dv::bench
