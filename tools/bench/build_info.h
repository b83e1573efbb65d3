#pragma once

namespace fire3dv::bench {

// The commit that this was built from, as `git describe` names it; "unknown" outside a git checkout.
extern const char* const kCommit;

}  // namespace fire3dv::bench
