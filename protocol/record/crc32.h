// CRC-32 as MCAP has it (ISO-HDLC, that of zlib).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::record {

// Goes on from the CRC of what stood before; 0 to begin with.
uint32_t crc32(std::span<const std::byte> bytes, uint32_t before = 0);

}  // namespace fire3dv::record
