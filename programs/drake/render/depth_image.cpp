#include "programs/drake/render/depth_image.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "base/error.h"

namespace fire3dv::drake {
namespace {

constexpr uint16_t kTooFar16 = 65535;
static_assert(std::endian::native == std::endian::little);  // the files are little-endian

float in_range_m(float depth_m, const DepthRange& range) {
  const auto depth = static_cast<double>(depth_m);
  if (!(depth < range.max_m)) return std::numeric_limits<float>::infinity();
  return depth > range.min_m ? depth_m : 0.0f;
}

uint16_t to_millimetres(float depth_m) {
  const double millimetres = std::round(static_cast<double>(depth_m) * 1000);
  return millimetres < kTooFar16 ? static_cast<uint16_t>(millimetres) : kTooFar16;
}

// Entry of a TIFF image file directory with one value.
struct Entry {
  uint16_t tag, type;
  uint32_t count, value;
};
static_assert(sizeof(Entry) == 12);
constexpr uint16_t kShort = 3, kLong = 4;  // types of values

// Header and directory of a file with one channel, uncompressed in one strip that follows directly.
std::string tiff_head(uint32_t width, uint32_t height, uint32_t bytes_per_pixel, bool is_float) {
  constexpr uint32_t kEntries = 11, kDirectory = 8;
  constexpr uint32_t kPixels = 152;  // offset: behind the directory, aligned to 8 bytes
  static_assert(kDirectory + 2 + kEntries * sizeof(Entry) + 4 <= kPixels);
  const std::array<Entry, kEntries> entries{{
      {256, kLong, 1, width},
      {257, kLong, 1, height},
      {258, kShort, 1, 8 * bytes_per_pixel},
      {259, kShort, 1, 1},  // no compression
      {262, kShort, 1, 1},  // 0 is black
      {273, kLong, 1, kPixels},
      {274, kShort, 1, 1},  // rows from the top
      {277, kShort, 1, 1},  // one channel
      {278, kLong, 1, height},
      {279, kLong, 1, width * height * bytes_per_pixel},
      {339, kShort, 1, is_float ? 3u : 1u},
  }};
  std::string head(kPixels, '\0');
  const std::array<uint16_t, 2> magic{0x4949, 42};
  const uint32_t directory = kDirectory;
  const uint16_t count = kEntries;
  std::memcpy(head.data(), magic.data(), sizeof magic);
  std::memcpy(head.data() + 4, &directory, sizeof directory);
  std::memcpy(head.data() + kDirectory, &count, sizeof count);
  std::memcpy(head.data() + kDirectory + 2, entries.data(), sizeof entries);
  return head;
}

template <typename Pixel>
void append(std::string& to, const std::vector<Pixel>& pixels) {
  const size_t begin = to.size();
  to.resize(begin + pixels.size() * sizeof(Pixel));
  std::memcpy(to.data() + begin, pixels.data(), pixels.size() * sizeof(Pixel));
}

}  // namespace

std::string encode_depth(std::span<const float> depths_m, uint32_t width, uint32_t height,
                         const DepthRange& range, DepthFormat format) {
  FIRE3DV_ASSERT(depths_m.size() == size_t{width} * height);
  std::vector<float> metres(depths_m.size());
  for (size_t i = 0; i < metres.size(); ++i) metres[i] = in_range_m(depths_m[i], range);
  const bool is_float = format == DepthFormat::float32_m;
  std::string file = tiff_head(width, height, is_float ? 4 : 2, is_float);
  if (is_float) {
    append(file, metres);
  } else {
    std::vector<uint16_t> millimetres(metres.size());
    for (size_t i = 0; i < metres.size(); ++i) millimetres[i] = to_millimetres(metres[i]);
    append(file, millimetres);
  }
  return file;
}

}  // namespace fire3dv::drake
