// Loops whose turns do not depend on each other, on all cores.
#pragma once

#include <cstddef>
#include <functional>

namespace fire3dv::scene {

// Calls work(0) .. work(count - 1), each once; the calling thread takes part. Which thread takes which turn
// is open, so a turn writes only what is its own, and results do not depend on how many threads there were.
// The first exception keeps further turns from starting and is thrown from here. `progress` is called on the
// calling thread, now and then.
void parallel_for(size_t count, const std::function<void(size_t)>& work,
                  const std::function<void(size_t done)>& progress = {});

}  // namespace fire3dv::scene
