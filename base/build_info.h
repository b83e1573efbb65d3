// Identity of the build, for --version.
#pragma once

namespace fire3dv {

extern const char* const kVersion;
extern const char* const kCommit;    // at configure time; "unknown" outside a git checkout
extern const char* const kFeatures;  // optional parts in this build, separated by commas

}  // namespace fire3dv
