// Keyed SipHash for names from untrusted peers, with a random key per process. Peers cannot choose colliding
// names. Values differ between runs and must not be stored or sent. Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace fire3dv {

uint64_t keyed_hash(std::string_view bytes);

// Hash functor for unordered containers with string keys. Together with std::equal_to<> it allows lookups by
// std::string_view.
struct KeyedHash {
  using is_transparent = void;
  size_t operator()(std::string_view bytes) const { return static_cast<size_t>(keyed_hash(bytes)); }
};

}  // namespace fire3dv
