// Chunk compression codecs. zstd is the default, lz4 is faster to write, and none suits file systems that
// compress.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "protocol/base/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {

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
