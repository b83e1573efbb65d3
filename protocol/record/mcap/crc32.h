// CRC-32 of MCAP (ISO-HDLC, the polynomial of zlib).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::record {

// Continues from the CRC of the preceding bytes; `before` is 0 at the beginning.
uint32_t crc32(std::span<const std::byte> bytes, uint32_t before = 0);

}  // namespace fire3dv::record
