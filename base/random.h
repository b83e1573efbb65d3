// Randomness that peers cannot predict: random ids, and hashes of names under a random key.
#pragma once

#include <sys/random.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"

namespace fire3dv {

// Random number from the kernel, for ids that attackers must not guess. Never 0, which means "none".
inline uint64_t random_id() {
  uint64_t id = 0;
  while (id == 0) {
    const ssize_t got = ::getrandom(&id, sizeof id, 0);
    FIRE3DV_ASSERT(got == sizeof id || (got < 0 && errno == EINTR));  // up to 256 bytes are never truncated
    if (got != sizeof id) id = 0;
  }
  return id;
}

// Keyed SipHash for names from untrusted peers, with a random key per process. Peers cannot choose colliding
// names. Values differ between runs and must not be stored or sent. Thread-safe.
uint64_t keyed_hash(std::string_view bytes);

// Hash functor for unordered containers with string keys. Together with std::equal_to<> it allows lookups by
// std::string_view.
struct KeyedHash {
  using is_transparent = void;
  size_t operator()(std::string_view bytes) const { return static_cast<size_t>(keyed_hash(bytes)); }
};

}  // namespace fire3dv
