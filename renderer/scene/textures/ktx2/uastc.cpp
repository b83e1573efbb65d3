#include "renderer/scene/textures/ktx2/uastc.h"

#include <string_view>

#include "renderer/scene/textures/ktx2/bit_reader.h"
#include "renderer/scene/textures/ktx2/uastc_partitions.h"

namespace fire3dv::scene::ktx2 {
namespace {

// Layout of a mode: the fields of a block in their order.
struct Mode {
  uint8_t code, code_bits;  // Huffman code that begins the block
  uint8_t hint_bits;        // hints for conversions to BC1, ETC1 and ETC2
  uint8_t pattern_bits;
  bool has_channel_of_second_plane;
  uint8_t subsets, channels;        // channels: 2 luminance and alpha, 3 RGB, 4 RGBA
  uint8_t digit_base;               // of an endpoint's leading digit: 3 or 5; 1: it has none
  uint8_t endpoint_bits;            // below the digit
  uint8_t planes, bits_of_weights;  // planes: sets of weights
};

constexpr size_t kModes = 19, kSolidColor = 8;
constexpr std::array<Mode, kModes> kModeTable{{
    {0x01, 4, 15, 0, false, 1, 3, 3, 6, 1, 4},  // 0
    {0x35, 6, 15, 0, false, 1, 3, 1, 8, 1, 2}, {0x1D, 5, 15, 5, false, 2, 3, 1, 4, 1, 3},
    {0x03, 5, 15, 4, false, 3, 3, 3, 2, 1, 2}, {0x13, 5, 15, 5, false, 2, 3, 5, 3, 1, 2},
    {0x0B, 5, 15, 0, false, 1, 3, 1, 8, 1, 3},  // 5
    {0x1B, 5, 15, 0, true, 1, 3, 5, 5, 2, 2},  {0x07, 5, 15, 5, false, 2, 3, 5, 3, 1, 2},
    {0x17, 5, 0, 0, false, 1, 4, 1, 8, 0, 0},                                              // one colour
    {0x0F, 5, 23, 5, false, 2, 4, 1, 4, 1, 2}, {0x02, 3, 17, 0, false, 1, 4, 3, 4, 1, 4},  // 10
    {0x00, 2, 17, 0, true, 1, 4, 3, 4, 2, 2},  {0x06, 3, 17, 0, false, 1, 4, 3, 6, 1, 3},
    {0x1F, 5, 23, 0, true, 1, 4, 1, 8, 2, 1},  {0x0D, 5, 23, 0, false, 1, 4, 1, 8, 1, 2},
    {0x05, 7, 23, 0, false, 1, 2, 1, 8, 1, 4},  // 15
    {0x15, 6, 23, 5, false, 2, 2, 1, 8, 1, 2}, {0x25, 6, 23, 0, false, 1, 2, 1, 8, 2, 2},
    {0x09, 4, 15, 0, false, 1, 3, 1, 5, 1, 5},
}};

// kModes: the code is reserved or invalid.
size_t mode_of(uint8_t first_byte) {
  size_t mode = 0;
  while (mode < kModes && (first_byte & ((1u << kModeTable[mode].code_bits) - 1)) != kModeTable[mode].code)
    ++mode;
  return mode;
}

constexpr std::string_view kOneSubset = "0000000000000000";

// Empty: there is no such pattern.
std::string_view partition_of(size_t mode, uint32_t pattern) {
  if (kModeTable[mode].subsets == 1) return kOneSubset;
  if (mode == 3) return pattern < kThreeSubsets.size() ? kThreeSubsets[pattern] : std::string_view();
  if (mode == 7)
    return pattern < kTwoSubsetsOfMode7.size() ? kTwoSubsetsOfMode7[pattern] : std::string_view();
  return pattern < kTwoSubsets.size() ? kTwoSubsets[pattern] : std::string_view();
}

// Expands a value of up to 8 bits to `bits` bits by repeating it from the top.
uint32_t replicated(uint32_t value, uint32_t from_bits, uint32_t bits) {
  uint32_t expanded = 0;
  for (uint32_t filled = 0; filled < bits; filled += from_bits) {
    const uint32_t rest = bits - filled;
    expanded |= rest >= from_bits ? value << (rest - from_bits) : value >> (from_bits - rest);
  }
  return expanded;
}

// ASTC's expansion of a digit with bits to 8 bits ("Color Endpoint Unquantization"): the digit times a
// factor, plus the bits above the lowest one spread over 9 bits, mirrored if the lowest bit is set.
uint32_t unquantized(const Mode& mode, uint32_t digit, uint32_t value) {
  if (mode.digit_base == 1) return replicated(value, mode.endpoint_bits, 8);
  const uint32_t a = (value & 1) != 0 ? 0x1ff : 0, high = value >> 1;
  uint32_t factor = 0, spread = 0;
  switch (mode.digit_base * 10 + mode.endpoint_bits) {
    case 32:  // b000b0bb0
      factor = 93;
      spread = high * 0b100010110;
      break;
    case 34:  // dcb000dcb
      factor = 22;
      spread = high << 6 | high;
      break;
    case 36:  // fedcb000f
      factor = 5;
      spread = high << 4 | high >> 4;
      break;
    case 53:  // cb0000cbc
      factor = 26;
      spread = high << 7 | high << 1 | high >> 1;
      break;
    case 55:  // edcb0000e
      factor = 6;
      spread = high << 5 | high >> 3;
      break;
    default:
      break;
  }
  const uint32_t mixed = (digit * factor + spread) ^ a;
  return (a & 0x80) | (mixed >> 2);
}

// Leading digits of the endpoint values, packed in groups: five of base 3 in 8 bits, three of base 5 in 7
// bits.
void read_digits(BitReader& reader, const Mode& mode, std::span<uint32_t> digits) {
  if (mode.digit_base == 1) return;
  constexpr std::array<uint8_t, 6> kTritBits{0, 2, 4, 5, 7, 8};
  const size_t group = mode.digit_base == 3 ? 5 : 3;
  for (size_t i = 0; i < digits.size(); i += group) {
    const size_t count = std::min(group, digits.size() - i);
    uint32_t packed = reader.bits(mode.digit_base == 3 ? kTritBits[count] : 7);
    for (size_t j = i; j < i + count; ++j) {
      digits[j] = packed % mode.digit_base;
      packed /= mode.digit_base;
    }
  }
}

struct Endpoints {
  Rgba8 low{0, 0, 0, 255}, high{0, 0, 0, 255};
};

std::array<Endpoints, 3> read_endpoints(BitReader& reader, const Mode& mode) {
  std::array<uint32_t, 18> digits{};
  const size_t count = size_t{2} * mode.channels * mode.subsets;
  read_digits(reader, mode, std::span(digits).first(count));
  std::array<Endpoints, 3> endpoints;
  for (size_t i = 0; i < count; ++i) {
    const auto value = static_cast<uint8_t>(unquantized(mode, digits[i], reader.bits(mode.endpoint_bits)));
    Endpoints& subset = endpoints[i / (size_t{2} * mode.channels)];
    Rgba8& color = i % 2 == 0 ? subset.low : subset.high;
    const size_t channel = i / 2 % mode.channels;
    if (mode.channels != 2) {
      color[channel] = value;
    } else if (channel == 0) {
      color[0] = color[1] = color[2] = value;
    } else {
      color[3] = value;
    }
  }
  return endpoints;
}

// 0 .. 64 from a weight's bits.
uint32_t unquantized_weight(uint32_t value, uint32_t bits) {
  const uint32_t weight = replicated(value, bits, 6);
  return weight > 32 ? weight + 1 : weight;
}

uint8_t interpolated(uint8_t low, uint8_t high, uint32_t weight, bool is_srgb) {
  const uint32_t from = uint32_t{low} << 8 | (is_srgb ? 0x80u : low);
  const uint32_t to = uint32_t{high} << 8 | (is_srgb ? 0x80u : high);
  return static_cast<uint8_t>((from * (64 - weight) + to * weight + 32) >> 6 >> 8);
}

BlockTexels filled(const Rgba8& color) {
  BlockTexels texels;
  texels.fill(color);
  return texels;
}

}  // namespace

BlockTexels decode_uastc(std::span<const std::byte, 16> block, bool is_srgb) {
  const size_t index = mode_of(static_cast<uint8_t>(block[0]));
  if (index == kModes) return filled(kUastcError);
  const Mode& mode = kModeTable[index];
  BitReader reader(block);
  reader.bits(mode.code_bits);
  if (index == kSolidColor) {
    Rgba8 color;
    for (uint8_t& channel : color) channel = static_cast<uint8_t>(reader.bits(8));
    return filled(color);
  }
  reader.bits(mode.hint_bits);
  const std::string_view partition = partition_of(index, reader.bits(mode.pattern_bits));
  if (partition.empty()) return filled(kUastcError);
  // Luminance and alpha in two planes: the second one is of alpha.
  const uint32_t second_channel = mode.has_channel_of_second_plane ? reader.bits(2) : 3;
  const std::array<Endpoints, 3> endpoints = read_endpoints(reader, mode);

  BlockTexels texels;
  uint32_t seen = 0;  // subsets whose first texel was read
  for (size_t i = 0; i < 16; ++i) {
    const auto subset = static_cast<uint32_t>(partition[i] - '0');
    // The highest bit of a subset's first weight is 0 and not stored.
    const bool is_anchor = (seen >> subset & 1) == 0;
    seen |= 1u << subset;
    std::array<uint32_t, 2> weights{};
    for (uint32_t plane = 0; plane < mode.planes; ++plane) {
      weights[plane] =
          unquantized_weight(reader.bits(mode.bits_of_weights - (is_anchor ? 1u : 0u)), mode.bits_of_weights);
    }
    const Endpoints& colors = endpoints[subset];
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t weight = mode.planes == 2 && c == second_channel ? weights[1] : weights[0];
      texels[i][c] = interpolated(colors.low[c], colors.high[c], weight, is_srgb);
    }
  }
  return texels;
}

}  // namespace fire3dv::scene::ktx2
