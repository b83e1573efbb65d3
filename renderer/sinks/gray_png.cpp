#include "renderer/sinks/gray_png.h"

#include <zlib.h>

#include <cstdlib>
#include <cstring>

namespace fire3dv::sinks {
namespace {

constexpr size_t kSignatureBytes = 8, kChunkHeadBytes = 8, kCrcBytes = 4, kHeaderBytes = 13;
constexpr int kBytesPerPixel = 2;

uint32_t be32(const uint8_t* at) {
  return uint32_t{at[0]} << 24 | uint32_t{at[1]} << 16 | uint32_t{at[2]} << 8 | at[3];
}

uint8_t paeth(uint8_t left, uint8_t above, uint8_t corner) {
  const int sum = left + above - corner;
  const int to_left = std::abs(sum - left), to_above = std::abs(sum - above),
            to_corner = std::abs(sum - corner);
  if (to_left <= to_above && to_left <= to_corner) return left;
  return to_above <= to_corner ? above : corner;
}

// Undoes the filter of a row in place. above: the row before, or null.
bool unfilter(uint8_t filter, uint8_t* row, const uint8_t* above, size_t row_bytes) {
  for (size_t i = 0; i < row_bytes; ++i) {
    const uint8_t left = i >= kBytesPerPixel ? row[i - kBytesPerPixel] : uint8_t{0};
    const uint8_t up = above ? above[i] : uint8_t{0};
    const uint8_t corner = above && i >= kBytesPerPixel ? above[i - kBytesPerPixel] : uint8_t{0};
    switch (filter) {
      case 0:
        return true;
      case 1:
        row[i] = static_cast<uint8_t>(row[i] + left);
        break;
      case 2:
        row[i] = static_cast<uint8_t>(row[i] + up);
        break;
      case 3:
        row[i] = static_cast<uint8_t>(row[i] + (left + up) / 2);
        break;
      case 4:
        row[i] = static_cast<uint8_t>(row[i] + paeth(left, up, corner));
        break;
      default:
        return false;
    }
  }
  return true;
}

}  // namespace

std::optional<Gray16> decode_gray16(std::span<const uint8_t> png, uint64_t max_pixels) {
  if (png.size() < kSignatureBytes + kChunkHeadBytes + kHeaderBytes) return std::nullopt;
  const uint8_t* const header = png.data() + kSignatureBytes + kChunkHeadBytes;
  Gray16 image{be32(header), be32(header + 4), {}};
  const bool is_gray16 = header[8] == 16 && header[9] == 0 && header[12] == 0;
  const uint64_t pixels = uint64_t{image.width} * image.height;
  if (!is_gray16 || pixels == 0 || pixels > max_pixels) return std::nullopt;
  std::vector<uint8_t> packed;
  for (size_t at = kSignatureBytes; png.size() - at >= kChunkHeadBytes + kCrcBytes;) {
    const size_t bytes = be32(png.data() + at);
    if (bytes > png.size() - at - kChunkHeadBytes - kCrcBytes) return std::nullopt;
    const uint8_t* const body = png.data() + at + kChunkHeadBytes;
    if (std::memcmp(png.data() + at + 4, "IDAT", 4) == 0) packed.insert(packed.end(), body, body + bytes);
    at += kChunkHeadBytes + bytes + kCrcBytes;
  }
  const size_t row_bytes = size_t{image.width} * kBytesPerPixel;
  std::vector<uint8_t> rows(image.height * (row_bytes + 1));
  uLongf unpacked_bytes = rows.size();
  if (::uncompress(rows.data(), &unpacked_bytes, packed.data(), packed.size()) != Z_OK ||
      unpacked_bytes != rows.size())
    return std::nullopt;
  image.pixels.reserve(pixels);
  for (uint32_t y = 0; y < image.height; ++y) {
    uint8_t* const row = rows.data() + y * (row_bytes + 1) + 1;
    if (!unfilter(row[-1], row, y > 0 ? row - (row_bytes + 1) : nullptr, row_bytes)) return std::nullopt;
    for (size_t x = 0; x < image.width; ++x)
      image.pixels.push_back(static_cast<uint16_t>(row[2 * x] << 8 | row[2 * x + 1]));
  }
  return image;
}

}  // namespace fire3dv::sinks
