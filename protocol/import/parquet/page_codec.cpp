#include "protocol/import/parquet/page_codec.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace fire3dv::imported {
namespace {

bool inflate_gzip(std::span<const std::byte> packed, std::span<std::byte> to) {
  constexpr int kGzipOrZlib = 15 + 32;
  z_stream stream{};
  if (::inflateInit2(&stream, kGzipOrZlib) != Z_OK) return false;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(to.data());
  stream.avail_out = static_cast<uInt>(to.size());
  const int done = ::inflate(&stream, Z_FINISH);
  const bool is_whole = done == Z_STREAM_END && stream.avail_out == 0;
  ::inflateEnd(&stream);
  return is_whole;
}

}  // namespace

bool unsnap(std::span<const std::byte> packed, std::span<std::byte> to) {
  size_t at = 0, done = 0;
  const auto number = [&](size_t bytes, uint32_t& value) {
    if (bytes > packed.size() - at) return false;
    value = 0;
    for (size_t i = 0; i < bytes; ++i) value |= static_cast<uint32_t>(packed[at + i]) << (8 * i);
    at += bytes;
    return true;
  };
  uint64_t size = 0;  // of the whole, as a varint
  for (int shift = 0;; shift += 7) {
    uint32_t part = 0;
    if (shift > 28 || !number(1, part)) return false;
    size |= uint64_t{part & 0x7f} << shift;
    if (part < 0x80) break;
  }
  if (size != to.size()) return false;
  while (at < packed.size()) {
    uint32_t tag = 0;
    if (!number(1, tag)) return false;
    uint64_t length = (tag >> 2) + 1;
    uint32_t offset = 0;
    switch (tag & 3) {
      case 0: {  // literal
        constexpr uint32_t kShort = 60;
        uint32_t more = 0;
        if (length > kShort) {
          if (!number(length - kShort, more)) return false;
          length = uint64_t{more} + 1;
        }
        if (length > packed.size() - at || length > to.size() - done) return false;
        std::memcpy(to.data() + done, packed.data() + at, length);
        at += length;
        done += length;
        continue;
      }
      case 1:
        if (!number(1, offset)) return false;
        length = (tag >> 2 & 7) + 4;
        offset |= (tag >> 5) << 8;
        break;
      case 2:
        if (!number(2, offset)) return false;
        break;
      default:
        if (!number(4, offset)) return false;
    }
    if (offset == 0 || offset > done || length > to.size() - done) return false;
    for (uint64_t i = 0; i < length; ++i, ++done) to[done] = to[done - offset];  // they may overlap
  }
  return done == to.size();
}

Result<void> check_codec(int64_t codec) {
  constexpr std::array kNames{"none", "Snappy", "gzip", "LZO", "Brotli", "LZ4", "Zstandard", "LZ4 raw"};
  if (codec == kUncompressed || codec == kSnappy || codec == kGzip || codec == kZstd) return {};
  const std::string name = codec > 0 && codec < static_cast<int64_t>(kNames.size())
                               ? std::string(kNames[static_cast<size_t>(codec)])
                               : "number " + std::to_string(codec);
  return Error{"its compression is " + name + "; Snappy, gzip and Zstandard are read"};
}

Result<std::vector<std::byte>> decompress(int64_t codec, std::span<const std::byte> packed, size_t size) {
  const Error damaged{"a compressed page is damaged"};
  if (codec == kUncompressed) {
    if (packed.size() != size) return damaged;
    return std::vector<std::byte>(packed.begin(), packed.end());
  }
  std::vector<std::byte> page(size);
  bool is_whole = false;
  if (codec == kSnappy)
    is_whole = unsnap(packed, page);
  else if (codec == kGzip)
    is_whole = size == 0 || inflate_gzip(packed, page);
  else
    is_whole = ::ZSTD_decompress(page.data(), page.size(), packed.data(), packed.size()) == page.size();
  if (!is_whole) return damaged;
  return page;
}

}  // namespace fire3dv::imported
