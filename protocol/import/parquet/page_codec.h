// Decompression of Parquet pages: none, Snappy, gzip and Zstandard. Bytes are untrusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::imported {

// Codes of parquet.thrift, CompressionCodec.
constexpr int64_t kUncompressed = 0, kSnappy = 1, kGzip = 2, kZstd = 6;

// Error for a codec that is not read; it names it.
Result<void> check_codec(int64_t codec);

// codec: one that check_codec() accepts. Fails unless the page has exactly `size` bytes, which the caller has
// limited.
Result<std::vector<std::byte>> decompress(int64_t codec, std::span<const std::byte> packed, size_t size);

// Of Snappy's raw format (github.com/google/snappy, format_description.txt).
bool unsnap(std::span<const std::byte> packed, std::span<std::byte> to);

}  // namespace fire3dv::imported
