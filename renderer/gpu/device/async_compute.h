// Use of an async compute queue, as the user chooses it.
#pragma once

#include <cstdint>

namespace fire3dv::gpu {

enum class AsyncCompute : uint8_t {
  automatic,  // an async compute queue where there is one
  on,         // always; without a second queue the submissions are serialised on the main queue
  off,        // one queue, one submission a frame
};

}  // namespace fire3dv::gpu
