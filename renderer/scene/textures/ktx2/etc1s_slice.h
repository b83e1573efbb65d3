// Slices of BasisLZ: the blocks of one image as references to the codebooks of endpoints and selectors.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/textures/ktx2/basis_lz.h"
#include "renderer/scene/textures/ktx2/huffman.h"

namespace fire3dv::scene::ktx2 {

// Codes that all slices of a file share.
struct SliceCodes {
  HuffmanCode prediction;      // how 2 x 2 blocks predict their endpoints
  HuffmanCode endpoint_delta;  // difference of indices, modulo the number of endpoints
  HuffmanCode selector;        // index, or place in the history
  HuffmanCode history_run;     // repeats of the newest selector of the history
  uint32_t history_size = 0;
};

// nullopt: the slice is damaged. Its time is proportional to the number of blocks.
std::optional<std::vector<Etc1sBlock>> decode_slice(std::span<const std::byte> bytes, const SliceCodes& codes,
                                                    std::span<const Etc1sEndpoint> endpoints,
                                                    std::span<const Etc1sSelector> selectors,
                                                    uint32_t columns, uint32_t rows);

}  // namespace fire3dv::scene::ktx2
