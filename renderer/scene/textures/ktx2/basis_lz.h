// BasisLZ: supercompression of ETC1S blocks (KTX 2.0, "BasisLZ/ETC1S Bitstream Specification").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/error.h"

namespace fire3dv::scene::ktx2 {

// ETC1S block of 4 x 4 texels: a colour, and for each texel one of four modifiers of its intensity.
struct Etc1sEndpoint {
  std::array<uint8_t, 3> color5{};  // red, green, blue: 0 .. 31
  uint8_t intensity = 0;            // modifier table: 0 .. 7
};
struct Etc1sSelector {
  std::array<uint8_t, 4> rows{};  // top row first; 2 bits a texel, the left one in the lowest bits
};
struct Etc1sBlock {
  Etc1sEndpoint endpoint;
  Etc1sSelector selector;
};

// Blocks of an image, row by row. The alpha slice is empty if the image has none.
struct Etc1sImage {
  std::vector<Etc1sBlock> color, alpha;
};

// global_data, level: of the file. columns, rows: size of level 0 in blocks. Errors are sentences about "it".
Result<Etc1sImage> decode_basis_lz(std::span<const std::byte> global_data, std::span<const std::byte> level,
                                   uint32_t columns, uint32_t rows, uint32_t level_count, bool has_alpha);

}  // namespace fire3dv::scene::ktx2
