#include "protocol/import/parquet/levels.h"

#include <algorithm>

namespace fire3dv::imported {

bool decode_hybrid(std::span<const std::byte> bytes, uint32_t width, size_t count,
                   std::vector<uint32_t>& values) {
  constexpr uint32_t kMaxWidth = 32;
  if (width > kMaxWidth) return false;
  const size_t end = values.size() + count;
  if (width == 0) {
    values.resize(end, 0);
    return true;
  }
  size_t at = 0;
  while (values.size() < end) {
    uint64_t head = 0;
    for (int shift = 0;; shift += 7) {
      if (at == bytes.size() || shift > 35) return false;
      const auto part = static_cast<uint8_t>(bytes[at++]);
      head |= uint64_t{part & 0x7fu} << shift;
      if (part < 0x80) break;
    }
    const size_t wanted = end - values.size();
    if ((head & 1) == 0) {
      const size_t value_bytes = (width + 7) / 8;
      if (value_bytes > bytes.size() - at) return false;
      uint32_t value = 0;
      for (size_t i = 0; i < value_bytes; ++i) value |= static_cast<uint32_t>(bytes[at + i]) << (8 * i);
      at += value_bytes;
      if (head >> 1 == 0) return false;  // no progress
      values.insert(values.end(), std::min<uint64_t>(head >> 1, wanted), value);
      continue;
    }
    const uint64_t packed = head >> 1;  // groups of eight values, `width` bytes each
    if (packed == 0 || packed > (bytes.size() - at) / width) return false;
    const std::span<const std::byte> group = bytes.subspan(at, packed * width);
    at += group.size();
    const size_t here = std::min<uint64_t>(8 * packed, wanted);
    for (uint64_t i = 0; i < here; ++i) {
      const uint64_t first = i * width;
      uint64_t word = 0;
      for (size_t k = 0; k < 5 && first / 8 + k < group.size(); ++k)
        word |= static_cast<uint64_t>(group[first / 8 + k]) << (8 * k);
      values.push_back(static_cast<uint32_t>(word >> (first % 8) & ((uint64_t{1} << width) - 1)));
    }
  }
  return true;
}

}  // namespace fire3dv::imported
