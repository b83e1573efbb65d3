// Parallel loop over independent iterations on all cores. Results must not depend on the number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace fire3dv {

// Calls work(0) .. work(count - 1) once each; the calling thread participates. The assignment to threads is
// unspecified, so an iteration writes its own data only. The first exception stops further iterations and is
// rethrown. `progress` runs on the calling thread.
void parallel_for(size_t count, const std::function<void(size_t)>& work,
                  const std::function<void(size_t done)>& progress = {});

}  // namespace fire3dv
