// Shortest decimals of floats, for files of JSON that keep them exactly.
#pragma once

#include <array>
#include <charconv>
#include <system_error>

namespace fire3dv::scene {

// The double whose shortest text names this float: readers that round it get the same float. Not a number and
// infinities are returned as they are.
inline double shortest(float value) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  double number = 0;
  if (error == std::errc() && std::from_chars(text.data(), end, number).ec == std::errc() &&
      static_cast<float>(number) == value)
    return number;
  return static_cast<double>(value);
}

}  // namespace fire3dv::scene
