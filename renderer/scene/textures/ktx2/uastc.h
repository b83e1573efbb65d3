// UASTC: blocks of 4 x 4 texels in 16 bytes, a subset of ASTC in a simpler coding (Khronos Data Format
// Specification, "Universal ASTC Compressed Texture Images").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fire3dv::scene::ktx2 {

using Rgba8 = std::array<uint8_t, 4>;
using BlockTexels = std::array<Rgba8, 16>;  // row by row, top row first

// Colour of texels in a block that is no UASTC.
constexpr Rgba8 kUastcError{255, 0, 255, 255};

// is_srgb: the block holds sRGB colours, which round differently.
BlockTexels decode_uastc(std::span<const std::byte, 16> block, bool is_srgb);

}  // namespace fire3dv::scene::ktx2
