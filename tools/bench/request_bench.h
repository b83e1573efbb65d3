// What it costs a simulator to ask for an image without waiting for it, beside publishing a frame.
#pragma once

namespace fire3dv::bench {

// Prints a table; returns the exit code.
int request_bench(int rounds);

}  // namespace fire3dv::bench
