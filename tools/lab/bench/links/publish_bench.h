// Cost of a publish over shared memory, against a bare copy of the same bytes.
#pragma once

namespace fire3dv::bench {

// Prints a table. Returns the exit code.
int publish_bench(int rounds);

}  // namespace fire3dv::bench
