// Decoder of Parquet's hybrid of runs and bit-packed groups (Encodings.md, "RLE"): repetition and definition
// levels, and indices of dictionaries. Bytes are untrusted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fire3dv::imported {

// Appends `count` values of `width` bits, 0 to 32. False: the bytes end before, or are damaged.
bool decode_hybrid(std::span<const std::byte> bytes, uint32_t width, size_t count,
                   std::vector<uint32_t>& values);

}  // namespace fire3dv::imported
