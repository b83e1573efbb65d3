// Cost of an image request without a wait, against publishing a frame.
#pragma once

namespace fire3dv::bench {

// Prints a table. Returns the exit code.
int request_bench(int rounds);

}  // namespace fire3dv::bench
