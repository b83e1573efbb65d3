#include "renderer/dataset/layouts/image_files.h"

#include <zlib.h>

#include <array>
#include <cstring>

#include "base/error.h"

namespace fire3dv::dataset {
namespace {

constexpr int kCompressionLevel = 1;  // the encoder shares its cores with the renderer
constexpr uint8_t kFilterUp = 2;      // difference to the pixel above: labels are constant over areas

void put_be32(std::vector<uint8_t>& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}

void put_chunk(std::vector<uint8_t>& bytes, const char* type, std::span<const uint8_t> body) {
  put_be32(bytes, static_cast<uint32_t>(body.size()));
  const size_t begin = bytes.size();
  bytes.insert(bytes.end(), type, type + 4);
  bytes.insert(bytes.end(), body.begin(), body.end());
  put_be32(bytes,
           static_cast<uint32_t>(::crc32(0, bytes.data() + begin, static_cast<uInt>(bytes.size() - begin))));
}

std::vector<uint8_t> encode_png(std::span<const uint8_t> big_endian, uint32_t width, uint32_t height,
                                uint8_t bits) {
  const size_t row_bytes = size_t{width} * (bits / 8);
  std::vector<uint8_t> filtered(height * (row_bytes + 1));
  for (uint32_t y = 0; y < height; ++y) {
    uint8_t* out = filtered.data() + y * (row_bytes + 1);
    const uint8_t* row = big_endian.data() + y * row_bytes;
    *out++ = kFilterUp;
    if (y == 0) {
      std::memcpy(out, row, row_bytes);
      continue;
    }
    const uint8_t* above = row - row_bytes;
    for (size_t i = 0; i < row_bytes; ++i) out[i] = static_cast<uint8_t>(row[i] - above[i]);
  }
  uLongf packed_bytes = ::compressBound(filtered.size());
  std::vector<uint8_t> packed(packed_bytes);
  FIRE3DV_ASSERT(
      ::compress2(packed.data(), &packed_bytes, filtered.data(), filtered.size(), kCompressionLevel) == Z_OK);
  std::vector<uint8_t> header;
  put_be32(header, width);
  put_be32(header, height);
  header.insert(header.end(), {bits, 0, 0, 0, 0});  // grey, deflate, adaptive filters, not interlaced
  std::vector<uint8_t> file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  put_chunk(file, "IHDR", header);
  put_chunk(file, "IDAT", {packed.data(), packed_bytes});
  put_chunk(file, "IEND", {});
  return file;
}

void put_le(std::vector<uint8_t>& bytes, uint32_t value, int count) {
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

}  // namespace

std::vector<uint8_t> encode_gray_png(std::span<const uint8_t> pixels, uint32_t width, uint32_t height) {
  return encode_png(pixels, width, height, 8);
}

std::vector<uint8_t> encode_gray_png(std::span<const uint16_t> pixels, uint32_t width, uint32_t height) {
  std::vector<uint8_t> big_endian(2 * pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    big_endian[2 * i] = static_cast<uint8_t>(pixels[i] >> 8);
    big_endian[2 * i + 1] = static_cast<uint8_t>(pixels[i]);
  }
  return encode_png(big_endian, width, height, 16);
}

std::vector<uint8_t> encode_tiff(std::span<const uint16_t> samples, uint32_t width, uint32_t height,
                                 uint16_t channels) {
  struct Entry {
    uint16_t tag, type;
    uint32_t count, value;
  };
  constexpr uint16_t kShort = 3, kLong = 4;
  constexpr uint32_t kHeaderBytes = 8, kEntries = 11;
  const uint32_t after_directory = kHeaderBytes + 2 + 12 * kEntries + 4;
  const uint32_t pixels_at = after_directory + (channels == 3 ? 8u : 0u);  // bits of three channels, padded
  const auto size_bytes = static_cast<uint32_t>(2 * samples.size());
  const std::array<Entry, kEntries> entries{{
      {256, kLong, 1, width},
      {257, kLong, 1, height},
      {258, kShort, channels, channels == 3 ? after_directory : 16u},  // bits per sample
      {259, kShort, 1, 1},                                             // not compressed
      {262, kShort, 1, channels == 3 ? 2u : 1u},                       // RGB, or black is 0
      {273, kLong, 1, pixels_at},
      {277, kShort, 1, channels},
      {278, kLong, 1, height},  // rows of the one strip
      {279, kLong, 1, size_bytes},
      {284, kShort, 1, 1},         // interleaved
      {339, kShort, channels, 1},  // unsigned integers; of three channels: below
  }};
  std::vector<uint8_t> file{'I', 'I', 42, 0};
  file.reserve(pixels_at + size_bytes);
  put_le(file, kHeaderBytes, 4);
  const bool is_rgb = channels == 3;
  put_le(file, is_rgb ? kEntries - 1 : kEntries, 2);
  for (const Entry& entry : entries) {
    if (is_rgb && entry.tag == 339) continue;  // the default
    put_le(file, entry.tag, 2);
    put_le(file, entry.type, 2);
    put_le(file, entry.count, 4);
    put_le(file, entry.value, 4);
  }
  put_le(file, 0, 4);  // no further image
  file.resize(after_directory);
  if (is_rgb) {
    for (int i = 0; i < 3; ++i) put_le(file, 16, 2);
    put_le(file, 0, 2);
  }
  for (const uint16_t sample : samples) put_le(file, sample, 2);
  return file;
}

}  // namespace fire3dv::dataset
