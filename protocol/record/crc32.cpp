#include "protocol/record/crc32.h"

#include <array>

namespace fire3dv::record {
namespace {

// Sixteen bytes a step: table k holds the CRC of a byte with k zero bytes behind it.
constexpr size_t kStep = 16;
using Tables = std::array<std::array<uint32_t, 256>, kStep>;

constexpr Tables make_tables() {
  Tables tables{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
    tables[0][i] = crc;
  }
  for (size_t k = 1; k < kStep; ++k)
    for (size_t i = 0; i < 256; ++i)
      tables[k][i] = tables[k - 1][i] >> 8 ^ tables[0][tables[k - 1][i] & 0xff];
  return tables;
}

constexpr Tables kTables = make_tables();

}  // namespace

uint32_t crc32(std::span<const std::byte> bytes, uint32_t before) {
  uint32_t crc = ~before;
  const auto* at = reinterpret_cast<const uint8_t*>(bytes.data());
  size_t left = bytes.size();
  for (; left >= kStep; at += kStep, left -= kStep) {
    uint32_t next = 0;
    for (size_t i = 0; i < 4; ++i) next ^= kTables[kStep - 1 - i][(crc >> 8 * i & 0xff) ^ at[i]];
    for (size_t i = 4; i < kStep; ++i) next ^= kTables[kStep - 1 - i][at[i]];
    crc = next;
  }
  for (; left > 0; ++at, --left) crc = crc >> 8 ^ kTables[0][(crc & 0xff) ^ *at];
  return ~crc;
}

}  // namespace fire3dv::record
