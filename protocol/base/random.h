// Random numbers from the kernel, for ids that attackers must not guess.
#pragma once

#include <sys/random.h>

#include <cerrno>
#include <cstdint>

#include "protocol/base/error.h"

namespace fire3dv {

// Never 0, which means "none".
inline uint64_t random_id() {
  uint64_t id = 0;
  while (id == 0) {
    const ssize_t got = ::getrandom(&id, sizeof id, 0);
    FIRE3DV_ASSERT(got == sizeof id || (got < 0 && errno == EINTR));  // up to 256 bytes are never truncated
    if (got != sizeof id) id = 0;
  }
  return id;
}

}  // namespace fire3dv
