// SipHash of names from outside, with a random key per process: hash tables of such names cannot be filled
// with chosen collisions. Values differ from run to run and must not be stored or sent. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace fire3dv {

uint64_t keyed_hash(std::string_view bytes);

// Hash of unordered containers with string keys; with std::equal_to<> they are searched by std::string_view.
struct KeyedHash {
  using is_transparent = void;
  size_t operator()(std::string_view bytes) const { return static_cast<size_t>(keyed_hash(bytes)); }
};

}  // namespace fire3dv
