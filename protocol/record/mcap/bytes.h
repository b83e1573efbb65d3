// Encoding of bytes in MCAP files: integers and strings (little-endian, independent of the host; reads are
// bounds-checked), check sums, and compression of chunks.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
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

// CRC-32 of MCAP (ISO-HDLC, the polynomial of zlib). Continues from the CRC of the preceding bytes; `before`
// is 0 at the beginning.
uint32_t crc32(std::span<const std::byte> bytes, uint32_t before = 0);

// Codecs of chunks. zstd is the default, lz4 is faster to write, and none suits file systems that compress.
enum class Compression : uint8_t { none, zstd, lz4 };
// Name of the codec in MCAP files; empty for none.
std::string_view compression_name(Compression compression);
std::optional<Compression> compression_of(std::string_view name);

// Codec context, reused for many chunks to retain the library's memory.
class Compressor {
 public:
  Compressor();
  ~Compressor();
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;

  // Appends the compressed bytes to `to`. Returns false and leaves `to` unchanged if they would not be
  // shorter.
  bool compress(Compression compression, std::span<const std::byte> bytes, wire::Bytes& to);
  // Fills `to` exactly or returns an error. Memory use does not depend on sizes claimed in `packed`.
  Result<void> decompress(Compression compression, std::span<const std::byte> packed,
                          std::span<std::byte> to);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Upper bound of the compressed size of so many bytes.
uint64_t max_compressed_bytes(uint64_t uncompressed_bytes);

}  // namespace fire3dv::record
