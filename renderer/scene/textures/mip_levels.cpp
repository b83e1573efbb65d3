#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "base/parallel.h"
#include "renderer/scene/textures/images.h"

namespace fire3dv::scene {
namespace {

constexpr uint32_t kLinearSteps = 65535;

// 16-bit linear light, so that the darkest sRGB codes are 20 steps apart.
struct SrgbTables {
  std::array<uint16_t, 256> linear{};
  std::array<uint8_t, kLinearSteps + 1> encoded{};

  SrgbTables() {
    for (size_t c = 0; c < linear.size(); ++c) linear[c] = steps_of(static_cast<double>(c));
    uint32_t next = 0;
    for (uint32_t c = 0; c < 256; ++c) {
      const uint32_t end = c == 255 ? kLinearSteps + 1 : steps_of(c + 0.5);
      for (; next < end; ++next) encoded[next] = static_cast<uint8_t>(c);
    }
  }
  static uint16_t steps_of(double code) {
    const double s = code / 255;
    const double light = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    return static_cast<uint16_t>(std::lround(light * kLinearSteps));
  }
};

const SrgbTables& srgb_tables() {
  static const SrgbTables tables;
  return tables;
}

// Box filter taps of one target texel along a side of `size` texels.
struct Taps {
  uint32_t first, count;
  std::array<uint32_t, 3> weight;  // sum: `size` if it is odd, else 2
};

Taps taps_at(uint32_t size, uint32_t x) {
  const uint32_t half = size / 2;
  if (size == 1) return {0, 1, {2, 0, 0}};
  if (size % 2 == 0) return {2 * x, 2, {1, 1, 0}};
  return {2 * x, 3, {half - x, half, x + 1}};
}

struct Level {
  std::span<const uint8_t> rgba8;
  uint32_t width, height;
};

uint32_t pixel_at(const uint8_t* texels, size_t i) {
  uint32_t pixel = 0;
  std::memcpy(&pixel, texels + 4 * i, sizeof(pixel));
  return pixel;
}

// SIMD within a register: two bytes at a time, each in 16 bits.
uint32_t mean_of(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  constexpr uint32_t kBytes = 0x00ff00ff, kRound = 0x00020002;
  const uint32_t low = (a & kBytes) + (b & kBytes) + (c & kBytes) + (d & kBytes) + kRound;
  const uint32_t high =
      (a >> 8 & kBytes) + (b >> 8 & kBytes) + (c >> 8 & kBytes) + (d >> 8 & kBytes) + kRound;
  return (low >> 2 & kBytes) | (high >> 2 & kBytes) << 8;
}

// Fast path: both sides are even.
void halve_even_row(const Level& from, bool srgb, uint32_t y, uint8_t* to) {
  const uint8_t* const upper = from.rgba8.data() + size_t{8} * y * from.width;
  const uint8_t* const lower = upper + size_t{4} * from.width;
  const SrgbTables& tables = srgb_tables();
  for (uint32_t x = 0; x < from.width / 2; ++x, to += 4) {
    const uint32_t mean = mean_of(pixel_at(upper, 2 * x), pixel_at(upper, 2 * x + 1), pixel_at(lower, 2 * x),
                                  pixel_at(lower, 2 * x + 1));
    std::memcpy(to, &mean, sizeof(mean));
    if (!srgb) continue;
    const uint8_t *const a = upper + size_t{8} * x, *const b = lower + size_t{8} * x;
    for (int c = 0; c < 3; ++c) {
      const uint32_t sum =
          tables.linear[a[c]] + tables.linear[a[c + 4]] + tables.linear[b[c]] + tables.linear[b[c + 4]];
      to[c] = tables.encoded[(sum + 2) / 4];
    }
  }
}

void halve_row(const Level& from, bool srgb, uint32_t y, uint8_t* to) {
  const SrgbTables& tables = srgb_tables();
  const Taps rows = taps_at(from.height, y);
  for (uint32_t x = 0; x < std::max(from.width / 2, 1u); ++x) {
    const Taps columns = taps_at(from.width, x);
    for (uint32_t c = 0; c < 4; ++c) {
      const bool linear = !srgb || c == 3;
      uint64_t sum = 0, weights = 0;
      for (uint32_t j = 0; j < rows.count; ++j) {
        for (uint32_t i = 0; i < columns.count; ++i) {
          const uint64_t weight = uint64_t{rows.weight[j]} * columns.weight[i];
          const uint8_t value = from.rgba8[4 * (size_t{rows.first + j} * from.width + columns.first + i) + c];
          sum += weight * (linear ? value : tables.linear[value]);
          weights += weight;
        }
      }
      const auto mean = static_cast<uint32_t>((sum + weights / 2) / weights);
      *to++ = linear ? static_cast<uint8_t>(mean) : tables.encoded[mean];
    }
  }
}

std::vector<uint8_t> halved(const Level& from, bool srgb) {
  const uint32_t width = std::max(from.width / 2, 1u), height = std::max(from.height / 2, 1u);
  std::vector<uint8_t> smaller(size_t{4} * width * height);
  const bool even = from.width % 2 == 0 && from.height % 2 == 0;
  const uint32_t rows_a_turn = std::max((1u << 16) / width, 1u);
  parallel_for((height + rows_a_turn - 1) / rows_a_turn, [&](size_t turn) {
    const auto first = static_cast<uint32_t>(turn) * rows_a_turn;
    for (uint32_t y = first; y < std::min(height, first + rows_a_turn); ++y) {
      uint8_t* const row = smaller.data() + size_t{4} * y * width;
      if (even) {
        halve_even_row(from, srgb, y, row);
      } else {
        halve_row(from, srgb, y, row);
      }
    }
  });
  return smaller;
}

}  // namespace

std::vector<std::vector<uint8_t>> generate_mip_levels(const Image& image, bool srgb) {
  std::vector<std::vector<uint8_t>> levels;
  Level level{image.rgba8, image.width, image.height};
  while (level.width > 1 || level.height > 1) {
    levels.push_back(halved(level, srgb));
    level = {levels.back(), std::max(level.width / 2, 1u), std::max(level.height / 2, 1u)};
  }
  return levels;
}

}  // namespace fire3dv::scene
