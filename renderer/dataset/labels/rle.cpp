#include "renderer/dataset/labels/rle.h"

#include <algorithm>

namespace fire3dv::dataset {
namespace {

// Five bits a character, the lowest first, with the sign in the last one.
void append_number(std::string& text, int64_t number) {
  for (bool more = true; more;) {
    char bits = static_cast<char>(number & 0x1f);
    number >>= 5;
    more = (bits & 0x10) ? number != -1 : number != 0;
    if (more) bits = static_cast<char>(bits | 0x20);
    text += static_cast<char>(bits + 48);
  }
}

}  // namespace

std::map<uint32_t, Runs> masks_of_instances(std::span<const uint32_t> instances, uint32_t width,
                                            uint32_t height) {
  std::map<uint32_t, Runs> masks;
  for (uint32_t x = 0; x < width; ++x) {
    for (uint32_t y = 0; y < height;) {
      const uint32_t instance = instances[size_t{y} * width + x];
      uint32_t end = y + 1;
      while (end < height && instances[size_t{end} * width + x] == instance) ++end;
      if (instance != 0) {
        Runs& runs = masks[instance];
        const uint32_t first = x * height + y;
        if (!runs.empty() && runs.back().second == first)
          runs.back().second = x * height + end;
        else
          runs.emplace_back(first, x * height + end);
      }
      y = end;
    }
  }
  return masks;
}

uint64_t count_pixels(const Runs& runs) {
  uint64_t pixels = 0;
  for (const auto& [first, end] : runs) pixels += end - first;
  return pixels;
}

std::string encode_counts(const Runs& runs, uint64_t pixels) {
  std::vector<int64_t> counts;
  uint64_t at = 0;
  for (const auto& [first, end] : runs) {
    counts.push_back(static_cast<int64_t>(first - at));
    counts.push_back(static_cast<int64_t>(end - first));
    at = end;
  }
  if (at < pixels || counts.empty()) counts.push_back(static_cast<int64_t>(pixels - at));
  std::string text;
  for (size_t i = 0; i < counts.size(); ++i)
    append_number(text, i > 2 ? counts[i] - counts[i - 2] : counts[i]);
  return text;
}

Runs decode_counts(const std::string& counts, uint64_t pixels) {
  std::vector<int64_t> lengths;
  for (size_t at = 0; at < counts.size();) {
    int64_t number = 0;
    int shift = 0;
    for (bool more = true; more; shift += 5) {
      if (at == counts.size() || shift > 50) return {};
      const int bits = counts[at++] - 48;
      if (bits < 0 || bits > 0x3f) return {};
      number |= static_cast<int64_t>(bits & 0x1f) << shift;
      more = (bits & 0x20) != 0;
      if (!more && (bits & 0x10)) number |= -(int64_t{1} << (shift + 5));
    }
    if (lengths.size() > 2) number += lengths[lengths.size() - 2];
    if (number < 0 || static_cast<uint64_t>(number) > pixels) return {};
    lengths.push_back(number);
  }
  Runs runs;
  uint64_t at = 0;
  for (size_t i = 0; i < lengths.size(); ++i) {
    const uint64_t end = at + static_cast<uint64_t>(lengths[i]);
    if (end > pixels) return {};
    if (i % 2 == 1 && end > at) runs.emplace_back(static_cast<uint32_t>(at), static_cast<uint32_t>(end));
    at = end;
  }
  return at == pixels ? runs : Runs{};
}

std::vector<uint8_t> mask_pixels(const Runs& runs, uint32_t width, uint32_t height) {
  std::vector<uint8_t> pixels(size_t{width} * height);
  for (const auto& [first, end] : runs) {
    uint32_t x = first / height, y = first % height;
    for (uint32_t i = first; i < end; ++i) {
      pixels[size_t{y} * width + x] = 255;
      if (++y == height) {
        y = 0;
        ++x;
      }
    }
  }
  return pixels;
}

}  // namespace fire3dv::dataset
