// Test of UASTC blocks: blocks of every mode built by the specification's tables, and checksums of the pixels
// that the transcoder of Basis Universal makes of pseudo-random blocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/textures/ktx2/uastc.h"
#include "renderer/scene/textures/ktx2/uastc_partitions.h"
#include "tests/unit/renderer/scene/textures/ktx2/ktx2_builder.h"

namespace fire3dv::scene::ktx2 {
namespace {

using ktx2_test::BitWriter;

// Code of an endpoint and the 8-bit value that the specification's tables state for it.
struct Code {
  uint32_t digit, bits, value;
};
const std::vector<Code> k12Values{{0, 0, 0},  {0, 1, 255}, {0, 2, 69}, {0, 3, 186}, {1, 0, 23},  {1, 1, 232},
                                  {1, 2, 92}, {1, 3, 163}, {2, 0, 46}, {2, 1, 209}, {2, 2, 116}, {2, 3, 139}};
const std::vector<Code> k40Values{{0, 0, 0},   {0, 1, 255}, {0, 4, 65},  {1, 0, 6},
                                  {1, 3, 216}, {2, 1, 242}, {2, 7, 145}, {3, 2, 52},
                                  {3, 5, 171}, {4, 0, 26},  {4, 2, 58},  {4, 7, 132}};
const std::vector<Code> k48Values{{0, 0, 0},    {0, 1, 255}, {0, 14, 113}, {1, 0, 5},   {1, 9, 185},
                                  {1, 15, 136}, {2, 2, 27},  {2, 7, 196},  {2, 15, 131}};
const std::vector<Code> k160Values{{0, 0, 0},   {0, 1, 255}, {0, 16, 64},  {1, 0, 1},   {1, 31, 134},
                                   {2, 5, 236}, {3, 2, 12},  {3, 17, 187}, {4, 18, 78}, {4, 31, 129}};
const std::vector<Code> k192Values{{0, 0, 0},    {0, 1, 255}, {0, 32, 64}, {1, 2, 5},
                                   {1, 63, 130}, {2, 4, 10},  {2, 5, 245}, {2, 63, 129}};
const std::vector<Code> k16Values{{0, 0, 0}, {0, 1, 17}, {0, 9, 153}, {0, 15, 255}};
const std::vector<Code> k32Values{{0, 0, 0}, {0, 1, 8}, {0, 18, 148}, {0, 31, 255}};
const std::vector<Code> k256Values{{0, 0, 0}, {0, 1, 1}, {0, 77, 77}, {0, 200, 200}, {0, 255, 255}};

// Expansion of weights of 1 .. 5 bits.
const std::array<std::vector<uint32_t>, 6> kWeights{
    {{},
     {0, 64},
     {0, 21, 43, 64},
     {0, 9, 18, 27, 37, 46, 55, 64},
     {0, 4, 8, 12, 17, 21, 25, 29, 35, 39, 43, 47, 52, 56, 60, 64},
     {0,  2,  4,  6,  8,  10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30,
      34, 36, 38, 40, 42, 44, 46, 48, 50, 52, 54, 56, 58, 60, 62, 64}}};

// How one mode is written.
struct Layout {
  int mode;
  uint32_t code, code_bits, hint_bits, pattern_bits, selector_bits;
  uint32_t channels, subsets, planes, weight_bits;
  const std::vector<Code>* codes;
  uint32_t base, endpoint_bits;  // base 1: no digits
};
const std::vector<Layout> kLayouts{{0, 0x1, 4, 15, 0, 0, 3, 1, 1, 4, &k192Values, 3, 6},
                                   {1, 0x35, 6, 15, 0, 0, 3, 1, 1, 2, &k256Values, 1, 8},
                                   {2, 0x1d, 5, 15, 5, 0, 3, 2, 1, 3, &k16Values, 1, 4},
                                   {3, 0x3, 5, 15, 4, 0, 3, 3, 1, 2, &k12Values, 3, 2},
                                   {4, 0x13, 5, 15, 5, 0, 3, 2, 1, 2, &k40Values, 5, 3},
                                   {5, 0xb, 5, 15, 0, 0, 3, 1, 1, 3, &k256Values, 1, 8},
                                   {6, 0x1b, 5, 15, 0, 2, 3, 1, 2, 2, &k160Values, 5, 5},
                                   {7, 0x7, 5, 15, 5, 0, 3, 2, 1, 2, &k40Values, 5, 3},
                                   {9, 0xf, 5, 23, 5, 0, 4, 2, 1, 2, &k16Values, 1, 4},
                                   {10, 0x2, 3, 17, 0, 0, 4, 1, 1, 4, &k48Values, 3, 4},
                                   {11, 0x0, 2, 17, 0, 2, 4, 1, 2, 2, &k48Values, 3, 4},
                                   {12, 0x6, 3, 17, 0, 0, 4, 1, 1, 3, &k192Values, 3, 6},
                                   {13, 0x1f, 5, 23, 0, 2, 4, 1, 2, 1, &k256Values, 1, 8},
                                   {14, 0xd, 5, 23, 0, 0, 4, 1, 1, 2, &k256Values, 1, 8},
                                   {15, 0x5, 7, 23, 0, 0, 2, 1, 1, 4, &k256Values, 1, 8},
                                   {16, 0x15, 6, 23, 5, 0, 2, 2, 1, 2, &k256Values, 1, 8},
                                   {17, 0x25, 6, 23, 0, 0, 2, 1, 2, 2, &k256Values, 1, 8},
                                   {18, 0x9, 4, 15, 0, 0, 3, 1, 1, 5, &k32Values, 1, 5}};

const std::string kWhole(16, '0');

std::vector<std::string_view> partitions_of(const Layout& layout) {
  if (layout.subsets == 1) return {kWhole};
  if (layout.mode == 3) return {kThreeSubsets.begin(), kThreeSubsets.end()};
  if (layout.mode == 7) return {kTwoSubsetsOfMode7.begin(), kTwoSubsetsOfMode7.end()};
  return {kTwoSubsets.begin(), kTwoSubsets.end()};
}

uint8_t mixed(uint32_t low, uint32_t high, uint32_t weight, bool is_srgb) {
  const uint32_t from = is_srgb ? low * 256 + 128 : low * 257, to = is_srgb ? high * 256 + 128 : high * 257;
  return static_cast<uint8_t>((from * (64 - weight) + to * weight + 32) / 64 / 256);
}

std::array<std::byte, 16> padded(std::vector<std::byte> bytes) {
  EXPECT_LE(bytes.size(), 16u);
  std::array<std::byte, 16> block{};
  std::copy(bytes.begin(), bytes.end(), block.begin());
  return block;
}

// Writes a block with random endpoints and weights and expects its texels.
void expect_block(const Layout& layout, uint32_t pattern, std::string_view partition, bool is_srgb,
                  std::mt19937& random) {
  BitWriter writer;
  writer.bits(layout.code, layout.code_bits);
  writer.bits(static_cast<uint32_t>(random()), layout.hint_bits);
  writer.bits(pattern, layout.pattern_bits);
  const uint32_t selector = layout.mode == 17 ? 3 : static_cast<uint32_t>(random() % 4);
  writer.bits(selector, layout.selector_bits);
  std::vector<Code> endpoints;
  for (uint32_t i = 0; i < 2 * layout.channels * layout.subsets; ++i)
    endpoints.push_back((*layout.codes)[random() % layout.codes->size()]);
  const size_t group = layout.base == 3 ? 5 : 3;
  for (size_t i = 0; layout.base > 1 && i < endpoints.size(); i += group) {
    uint32_t packed = 0, place = 1;
    const size_t end = std::min(i + group, endpoints.size());
    for (size_t j = i; j < end; ++j, place *= layout.base) packed += endpoints[j].digit * place;
    const std::array<uint32_t, 6> trit_bits{0, 2, 4, 5, 7, 8};
    writer.bits(packed, layout.base == 3 ? trit_bits[end - i] : 7);
  }
  for (const Code& code : endpoints) writer.bits(code.bits, layout.endpoint_bits);

  std::vector<Rgba8> expected;
  std::string seen;
  for (size_t i = 0; i < 16; ++i) {
    const bool is_anchor = seen.find(partition[i]) == std::string::npos;
    seen += partition[i];
    std::array<uint32_t, 2> weights{};
    for (uint32_t plane = 0; plane < layout.planes; ++plane) {
      const uint32_t bits = layout.weight_bits - (is_anchor ? 1 : 0);
      const auto coded = static_cast<uint32_t>(random() % (uint64_t{1} << bits));
      writer.bits(coded, bits);
      weights[plane] = kWeights[layout.weight_bits][coded];
    }
    const Code* const subset =
        &endpoints[size_t{2} * layout.channels * static_cast<size_t>(partition[i] - '0')];
    Rgba8 texel{0, 0, 0, 255};
    for (uint32_t c = 0; c < 4; ++c) {
      if (c == 3 && layout.channels == 3) continue;
      const uint32_t source = layout.channels == 2 ? (c == 3 ? 1 : 0) : c;
      const uint32_t weight = weights[layout.planes == 2 && c == selector ? 1 : 0];
      texel[c] = mixed(subset[2 * source].value, subset[2 * source + 1].value, weight, is_srgb);
    }
    expected.push_back(texel);
  }
  const BlockTexels texels = decode_uastc(padded(writer.bytes()), is_srgb);
  EXPECT_TRUE(std::equal(texels.begin(), texels.end(), expected.begin()))
      << "mode " << layout.mode << ", pattern " << pattern;
}

TEST(Uastc, ModesMatchTheSpecification) {
  std::mt19937 random(1);
  for (const Layout& layout : kLayouts) {
    const std::vector<std::string_view> partitions = partitions_of(layout);
    for (uint32_t pattern = 0; pattern < partitions.size(); ++pattern) {
      for (int i = 0; i < 20; ++i) expect_block(layout, pattern, partitions[pattern], i % 2 == 1, random);
    }
  }
}

// First texels of the subsets, from a table of its own in the specification.
TEST(Uastc, PartitionsHaveAnchorsOfSpecification) {
  const auto anchors = [](const auto& partitions) {
    std::string all;
    for (const std::string_view partition : partitions) {
      for (char subset = '0'; partition.find(subset) != std::string_view::npos; ++subset)
        all += std::to_string(partition.find(subset)) +
               (partition.find(static_cast<char>(subset + 1)) != std::string_view::npos ? "," : " ");
    }
    return all;
  };
  EXPECT_EQ(anchors(kTwoSubsets),
            "0,2 0,3 1,0 0,3 7,0 0,2 3,0 7,0 0,11 2,0 0,7 11,0 3,0 8,0 0,4 12,0 1,0 8,0 0,1 0,2 0,4 8,0 1,0 "
            "0,2 4,0 0,1 4,0 1,0 4,0 1,0 ");
  EXPECT_EQ(anchors(kTwoSubsetsOfMode7),
            "0,4 0,2 2,0 0,7 8,0 0,1 0,3 0,1 2,0 0,1 0,8 2,0 0,1 0,7 12,0 2,0 9,0 0,2 4,0 ");
  EXPECT_EQ(anchors(kThreeSubsets), "0,8,10 8,0,12 4,0,12 8,0,4 3,0,2 0,1,3 0,2,1 1,9,0 1,2,0 4,0,8 0,6,2 ");
}

TEST(Uastc, OneColour) {
  BitWriter writer;
  writer.bits(0x17, 5);
  for (const uint32_t channel : {10, 20, 30, 40}) writer.bits(channel, 8);
  for (const Rgba8& texel : decode_uastc(padded(writer.bytes()), true))
    EXPECT_EQ(texel, (Rgba8{10, 20, 30, 40}));
}

TEST(Uastc, InvalidBlockIsErrorColour) {
  const auto expect_error = [](const BitWriter& writer) {
    for (const Rgba8& texel : decode_uastc(padded(writer.bytes()), false)) EXPECT_EQ(texel, kUastcError);
  };
  BitWriter reserved;
  reserved.bits(0x45, 7);  // mode 19
  expect_error(reserved);
  for (const Layout& layout : kLayouts) {
    if (layout.subsets == 1) continue;
    BitWriter writer;
    writer.bits(layout.code, layout.code_bits);
    writer.bits(0, layout.hint_bits);
    writer.bits(static_cast<uint32_t>(partitions_of(layout).size()), layout.pattern_bits);
    expect_error(writer);
  }
}

// Pseudo-random blocks of a mode.
std::vector<std::byte> blocks_of(const Layout& layout, size_t count) {
  std::mt19937 random(static_cast<uint32_t>(layout.mode));
  const auto patterns = static_cast<uint32_t>(partitions_of(layout).size());
  std::vector<std::byte> bytes;
  for (size_t i = 0; i < count; ++i) {
    BitWriter writer;
    writer.bits(layout.code, layout.code_bits);
    writer.bits(static_cast<uint32_t>(random()), layout.hint_bits);
    writer.bits(static_cast<uint32_t>(i) % patterns, layout.pattern_bits);
    for (uint32_t at = layout.code_bits + layout.hint_bits + layout.pattern_bits; at < 128; ++at)
      writer.bits(static_cast<uint32_t>(random()) & 1, 1);
    bytes.insert(bytes.end(), writer.bytes().begin(), writer.bytes().end());
  }
  return bytes;
}

// The checksums are those of the pixels of three.js's build of the Basis Universal transcoder (RGBA32) for
// the same blocks in a KTX 2.0 file of 32 x 32 texels.
TEST(Uastc, RandomBlocksMatchBasisUniversal) {
  const std::vector<uint64_t> checksums{
      0xe98f00371dcc91ae, 0x10a32dab63666759, 0x9f0408eda6d8d1bf, 0xe3938511d04d4fe5, 0xc1c26e241aa32d61,
      0x2f89d9ea75598a63, 0x80e4e71df87dd185, 0xc6f5503d706e6282, 0xa7e0c26acbce912d, 0xd6bc5c49c2bd9e2b,
      0x2eb6795e59c409b9, 0x43d835940850c5fd, 0xf0f2555ffd755bf4, 0x1262e129d614b6f8, 0x2d274c8f4a69c10a,
      0x36b20fd34ad48e9c, 0x13773b961385797a, 0xcdbeb67b5ffb0068};
  ASSERT_EQ(checksums.size(), kLayouts.size());
  for (size_t i = 0; i < kLayouts.size(); ++i) {
    ktx2_test::Ktx2Builder builder;
    builder.width = builder.height = 32;
    builder.model = 166;
    builder.channels = {3};
    builder.level = blocks_of(kLayouts[i], 64);
    const std::vector<std::byte> file = builder.file();
    const Result<Image> image = ktx2_test::decoded(file);
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(ktx2_test::checksum(ktx2_test::texels_of(*image)), checksums[i]) << "mode " << kLayouts[i].mode;
  }
}

}  // namespace
}  // namespace fire3dv::scene::ktx2
