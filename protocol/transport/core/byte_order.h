// Little-endian encoding of integers in transport messages, independent of the host.
#pragma once

#include <concepts>
#include <cstddef>

namespace fire3dv::transport {

template <std::unsigned_integral T>
void put_le(std::byte* to, T value) {
  for (size_t i = 0; i < sizeof(T); ++i) to[i] = static_cast<std::byte>(value >> (8 * i));
}

template <std::unsigned_integral T>
T get_le(const std::byte* from) {
  T value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value | static_cast<T>(from[i]) << (8 * i));
  return value;
}

}  // namespace fire3dv::transport
