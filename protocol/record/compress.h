// What chunks are packed with. zstd is the default: lz4 is faster to write, and nothing at all suits files
// that are packed otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "protocol/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {

enum class Compression : uint8_t { none, zstd, lz4 };
// As the format has it: none is the empty text.
std::string_view compression_name(Compression compression);
std::optional<Compression> compression_of(std::string_view name);

// One for many chunks: keeps the library's memory.
class Compressor {
 public:
  Compressor();
  ~Compressor();
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;

  // Appends the packed bytes to `to`. False: they would not be fewer, and `to` is as before.
  bool compress(Compression compression, std::span<const std::byte> bytes, wire::Bytes& to);
  // Fills `to` exactly, or says why not. Takes no memory that `packed` asks for.
  Result<void> decompress(Compression compression, std::span<const std::byte> packed,
                          std::span<std::byte> to);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// No honest packing of so many bytes is longer.
uint64_t most_compressed_bytes(uint64_t uncompressed_bytes);

}  // namespace fire3dv::record
