// What one publish costs over shared memory, beside a bare copy of the same bytes.
#pragma once

namespace fire3dv::bench {

// Prints a table; returns the exit code.
int publish_bench(int rounds);

}  // namespace fire3dv::bench
