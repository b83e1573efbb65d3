// Canonical Huffman codes of BasisLZ (KTX 2.0, "Compressed Huffman Tables"): those of Deflate, with codes of
// up to 16 bits and up to 16383 symbols.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/textures/ktx2/bit_reader.h"

namespace fire3dv::scene::ktx2 {

class HuffmanCode {
 public:
  static constexpr uint32_t kMaxBits = 16;

  // The code with these lengths in bits, 0 for unused symbols. nullopt: the lengths are no prefix code. A
  // code may be incomplete: bits without a symbol fail to decode.
  static std::optional<HuffmanCode> from_lengths(std::span<const uint8_t> lengths);

  // Reads a table in its compressed form. nullopt: it is damaged.
  static std::optional<HuffmanCode> read(BitReader& reader);

  // Reads one symbol. nullopt: the bits are no code, or end.
  std::optional<uint32_t> decode(BitReader& reader) const;

 private:
  std::array<uint32_t, kMaxBits + 1> count_{};  // codes of each length
  std::vector<uint16_t> symbols_;               // in the order of their codes
};

}  // namespace fire3dv::scene::ktx2
