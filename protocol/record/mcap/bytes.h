// Little-endian encoding of the integers and strings of MCAP records, independent of the host. Reads are
// bounds-checked.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "protocol/wire/encode.h"

namespace fire3dv::record {

using wire::Bytes;

template <std::unsigned_integral T>
void put(Bytes& to, T value) {
  const size_t at = to.size();
  to.resize(at + sizeof(T));
  for (size_t i = 0; i < sizeof(T); ++i) to[at + i] = static_cast<std::byte>(value >> (8 * i));
}

inline void put(Bytes& to, std::span<const std::byte> bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

inline void put(Bytes& to, std::string_view text) {
  put(to, static_cast<uint32_t>(text.size()));
  put(to, std::as_bytes(std::span(text)));
}

class Parser {
 public:
  explicit Parser(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  bool get(T& value) {
    if (rest_.size() < sizeof(T)) return false;
    value = 0;
    for (size_t i = 0; i < sizeof(T); ++i)
      value = static_cast<T>(value | static_cast<T>(static_cast<uint8_t>(rest_[i])) << (8 * i));
    rest_ = rest_.subspan(sizeof(T));
    return true;
  }
  bool get(uint64_t length, std::span<const std::byte>& bytes) {
    if (length > rest_.size()) return false;
    bytes = rest_.first(static_cast<size_t>(length));
    rest_ = rest_.subspan(static_cast<size_t>(length));
    return true;
  }
  bool get(std::string& text) {
    uint32_t length = 0;
    std::span<const std::byte> bytes;
    if (!get(length) || !get(length, bytes)) return false;
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return true;
  }
  std::span<const std::byte> rest() const { return rest_; }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace fire3dv::record
