// Counts in messages: "1 frame", "2 frames".
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace fire3dv {

// The count and its noun. singular: a noun whose plural ends in -s.
template <std::unsigned_integral Count>
std::string counted(Count count, std::string_view singular) {
  return std::to_string(count) + " " + std::string(singular) + (count == 1 ? "" : "s");
}

}  // namespace fire3dv
