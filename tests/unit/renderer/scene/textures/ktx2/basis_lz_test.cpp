// Test of BasisLZ: codebooks and slices written bit by bit with the pixels that they mean, and files of the
// Basis Universal encoder.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "renderer/scene/files.h"
#include "tests/unit/renderer/scene/textures/ktx2/ktx2_builder.h"
#include "tests/unit/renderer/scene/textures/ktx2/ktx2_reference_files.h"

namespace fire3dv::scene::ktx2 {
namespace {

using ktx2_test::BitWriter;
using ktx2_test::checksum;
using ktx2_test::decoded;
using ktx2_test::texels_of;

// Codebooks of the tests: endpoints by difference, selectors whose texels are all equal.
constexpr uint32_t kEndpoints = 4, kSelectors = 4, kHistory = 4;
struct Endpoint {
  std::array<uint32_t, 3> color5;
  uint32_t intensity;
};
constexpr std::array<Endpoint, kEndpoints> kEndpointValues{
    {{{20, 3, 31}, 0}, {{1, 30, 12}, 7}, {{9, 10, 22}, 3}, {{21, 0, 5}, 4}}};

void write_endpoints(BitWriter& writer) {
  for (int i = 0; i < 3; ++i) writer.uniform_table(32, 5);
  writer.uniform_table(8, 3);
  writer.bits(0, 1);  // in colour
  std::array<uint32_t, 3> previous{16, 16, 16};
  uint32_t previous_intensity = 0;
  for (const Endpoint& endpoint : kEndpointValues) {
    writer.code((endpoint.intensity - previous_intensity) & 7, 3);
    for (size_t c = 0; c < 3; ++c) writer.code((endpoint.color5[c] - previous[c]) & 31, 5);
    previous = endpoint.color5;
    previous_intensity = endpoint.intensity;
  }
}

// Selector i has the value i at each texel, but for texel (1, 2), which has 0.
uint32_t selector_value(uint32_t selector, uint32_t x, uint32_t y) {
  return x == 1 && y == 2 ? 0 : selector;
}

void write_selectors(BitWriter& writer, bool is_raw) {
  writer.bits(0, 2);
  writer.bits(is_raw ? 1 : 0, 1);
  if (!is_raw) writer.uniform_table(256, 8);
  std::array<uint32_t, 4> previous{};
  for (uint32_t selector = 0; selector < kSelectors; ++selector) {
    for (uint32_t y = 0; y < 4; ++y) {
      uint32_t row = 0;
      for (uint32_t x = 0; x < 4; ++x) row |= selector_value(selector, x, y) << (2 * x);
      if (is_raw || selector == 0) {
        writer.bits(row, 8);
      } else {
        writer.code(row ^ previous[y], 8);
      }
      previous[y] = row;
    }
  }
}

// Symbols of slices are written with these.
constexpr uint32_t kPredictionBits = 9, kDeltaBits = 2, kSelectorBits = 4, kRunBits = 6;
constexpr uint32_t kRepeatPrediction = 256, kFromHistory = kSelectors, kRun = kSelectors + kHistory;

void write_tables(BitWriter& writer) {
  writer.uniform_table(257, kPredictionBits);
  writer.uniform_table(kEndpoints, kDeltaBits);
  writer.uniform_table(kSelectors + kHistory + 1, kSelectorBits);
  writer.uniform_table(64, kRunBits);
  writer.bits(kHistory, 13);
}

ktx2_test::Ktx2Builder etc1s_file(uint32_t columns, uint32_t rows, const BitWriter& slice,
                                  bool raw_selectors = false, uint32_t flags = 0) {
  BitWriter endpoints, selectors, tables;
  write_endpoints(endpoints);
  write_selectors(selectors, raw_selectors);
  write_tables(tables);
  ktx2_test::Ktx2Builder builder;
  builder.width = 4 * columns;
  builder.height = 4 * rows;
  builder.scheme = 1;
  builder.model = 163;
  builder.level = slice.bytes();
  BitWriter global;
  global.bits(kEndpoints, 16);
  global.bits(kSelectors, 16);
  for (const BitWriter* part : {&endpoints, &selectors, &tables})
    global.bits(static_cast<uint32_t>(part->bytes().size()), 32);
  global.bits(0, 32);
  for (const uint32_t word : {flags, 0u, static_cast<uint32_t>(slice.bytes().size()), 0u, 0u})
    global.bits(word, 32);
  builder.global_data = global.bytes();
  for (const BitWriter* part : {&endpoints, &selectors, &tables})
    builder.global_data.insert(builder.global_data.end(), part->bytes().begin(), part->bytes().end());
  return builder;
}

// ETC1's intensity modifiers for the tables that the endpoints use, by selector.
std::array<int, 4> modifiers_of(uint32_t intensity) {
  switch (intensity) {
    case 0:
      return {-8, -2, 2, 8};
    case 3:
      return {-42, -13, 13, 42};
    case 4:
      return {-60, -18, 18, 60};
    default:
      return {-183, -47, 47, 183};
  }
}

struct BlockIndices {
  uint32_t endpoint, selector;
};

void expect_image(const std::vector<std::byte>& file, uint32_t columns,
                  const std::vector<BlockIndices>& blocks) {
  const Result<Image> image = decoded(file);
  ASSERT_TRUE(image.ok()) << image.error().message;
  std::vector<uint8_t> expected;
  for (uint32_t y = 0; y < image->height; ++y) {
    for (uint32_t x = 0; x < image->width; ++x) {
      const BlockIndices& block = blocks[y / 4 * columns + x / 4];
      const Endpoint& endpoint = kEndpointValues[block.endpoint];
      const int modifier = modifiers_of(endpoint.intensity)[selector_value(block.selector, x % 4, y % 4)];
      for (const uint32_t c : endpoint.color5) {
        const int base = static_cast<int>(c * 8 + c / 4);
        expected.push_back(static_cast<uint8_t>(std::clamp(base + modifier, 0, 255)));
      }
      expected.push_back(255);
    }
  }
  EXPECT_EQ(texels_of(*image), expected);
}

// Writes how 2 x 2 blocks predict their endpoints: 0 from the left, 1 from above, 2 from above to the left, 3
// from the previous one by a difference.
void predict(BitWriter& slice, uint32_t upper_left, uint32_t upper_right, uint32_t lower_left,
             uint32_t lower_right) {
  slice.code(upper_left | upper_right << 2 | lower_left << 4 | lower_right << 6, kPredictionBits);
}
void delta(BitWriter& slice, uint32_t difference) {
  slice.code(difference, kDeltaBits);
}
void select(BitWriter& slice, uint32_t symbol) {
  slice.code(symbol, kSelectorBits);
}

// 3 x 3 blocks with every prediction, and each selector by its index.
BitWriter slice_of_predictions() {
  BitWriter slice;
  predict(slice, 3, 0, 1, 2);  // block (0, 0)
  delta(slice, 2);             // 0 + 2
  select(slice, 0);
  select(slice, 1);            // (1, 0): left, endpoint 2
  predict(slice, 3, 0, 3, 0);  // (2, 0), and (2, 1) below; without right neighbours
  delta(slice, 3);             // 2 + 3 - 4
  select(slice, 2);
  select(slice, 3);  // (0, 1): above, endpoint 2
  select(slice, 0);  // (1, 1): above to the left, endpoint 2
  delta(slice, 1);   // (2, 1): 2 + 1
  select(slice, 1);
  predict(slice, 3, 1, 0, 0);  // (0, 2)
  delta(slice, 1);             // 3 + 1 - 4
  select(slice, 2);
  select(slice, 3);            // (1, 2): above, endpoint 2
  predict(slice, 2, 0, 0, 0);  // (2, 2): above to the left, endpoint 2
  select(slice, 0);
  return slice;
}
const std::vector<BlockIndices> kPredicted{{2, 0}, {2, 1}, {1, 2}, {2, 3}, {2, 0},
                                           {3, 1}, {0, 2}, {2, 3}, {2, 0}};

TEST(BasisLz, EndpointsArePredicted) {
  expect_image(etc1s_file(3, 3, slice_of_predictions()).file(), 3, kPredicted);
}

TEST(BasisLz, RawSelectors) {
  expect_image(etc1s_file(3, 3, slice_of_predictions(), true).file(), 3, kPredicted);
}

TEST(BasisLz, BlocksOverhangTheImage) {
  ktx2_test::Ktx2Builder builder = etc1s_file(3, 3, slice_of_predictions());
  builder.width = 9;
  builder.height = 11;
  expect_image(builder.file(), 3, kPredicted);
}

TEST(BasisLz, RunsAndHistoryOfSelectors) {
  // 14 x 2 blocks of endpoint 1: one prediction, then runs of it.
  BitWriter slice;
  predict(slice, 3, 0, 1, 1);
  delta(slice, 1);
  select(slice, 1);  // history 0 0 1 0
  select(slice, 2);  // history 0 0 1 2
  predict(slice, 0, 0, 1, 1);
  select(slice, kFromHistory + 3);                 // 2; history 0 2 1 0
  select(slice, kFromHistory + 1);                 // 2; history 2 0 1 0
  slice.code(kRepeatPrediction, kPredictionBits);  // for the five other groups of 2 x 2
  slice.bits(2, 5);                                // 3 more than the least of 2 after this one: 5 in all
  select(slice, kRun);
  slice.code(4, kRunBits);          // 7 of the history's first, 2
  select(slice, kFromHistory + 2);  // 1; history 2 1 0 0
  select(slice, 3);                 // overwrites history 2: 2 1 3 0
  select(slice, kFromHistory + 2);  // 3; history 2 3 1 0
  select(slice, kRun);              // the second row: 14 blocks of 2, as a long run
  slice.code(63, kRunBits);
  slice.bits(11, 8);  // 11 + 3
  std::vector<BlockIndices> expected;
  for (const uint32_t selector : {1, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1, 3, 3})
    expected.push_back({1, selector});
  for (int i = 0; i < 14; ++i) expected.push_back({1, 2});
  expect_image(etc1s_file(14, 2, slice).file(), 14, expected);
}

TEST(BasisLz, BrokenSlicesAreRefused) {
  const auto reason = [](const std::function<void(BitWriter&)>& write, uint32_t flags = 0) {
    BitWriter slice;
    write(slice);
    for (int i = 0; i < 8; ++i) slice.bits(0, 8);
    const Result<Image> image = decoded(etc1s_file(2, 2, slice, false, flags).file());
    return image ? std::string("decoded") : image.error().message;
  };
  const std::string damaged = "its BasisLZ data is damaged";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 3, 0, 1, 1); }), "decoded")
      << "zeros are differences and indices";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 0, 0, 0, 0); }), damaged) << "nothing is to the left";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 1, 0, 0, 0); }), damaged) << "nothing is above";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 2, 0, 0, 0); }), damaged) << "nothing is above to the left";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 3, 0, 0, 0); }), damaged)
      << "(0, 1) has nothing to the left";
  EXPECT_EQ(reason([](BitWriter& s) {
              predict(s, 3, 0, 1, 1);
              delta(s, 0);
              select(s, kRun + 1);
            }),
            damaged)
      << "no such symbol";
  EXPECT_EQ(reason([](BitWriter& s) { s.code(300, kPredictionBits); }), damaged) << "no such code";
  EXPECT_EQ(reason([](BitWriter& s) { predict(s, 3, 0, 1, 1); }, 2),
            "its first image is a P frame of an animation");
  EXPECT_FALSE(decoded(etc1s_file(2, 2, BitWriter()).file()).ok()) << "an empty slice";
}

std::vector<std::byte> file_of(const char* base64) {
  const auto bytes = AssetFolder::none().read(std::string("data:;base64,") + base64, 1 << 20);
  EXPECT_TRUE(bytes.ok());
  const auto view = bytes->view();
  return {view.begin(), view.end()};
}

TEST(BasisLz, EncoderFilesMatchTranscoder) {
  for (const auto& [text, expected] : {std::pair(ktx2_test::kRgbFile, ktx2_test::kRgbChecksum),
                                       std::pair(ktx2_test::kRgbaFile, ktx2_test::kRgbaChecksum)}) {
    const Result<Image> image = decoded(file_of(text));
    ASSERT_TRUE(image.ok()) << image.error().message;
    EXPECT_EQ(image->width, 58u);
    EXPECT_EQ(image->height, 30u);
    EXPECT_EQ(checksum(texels_of(*image)), expected);
  }
}

TEST(BasisLz, DamagedFilesAreSafe) {
  for (const std::vector<std::byte>& file :
       {etc1s_file(3, 3, slice_of_predictions()).file(), file_of(ktx2_test::kRgbaFile)}) {
    const size_t refused =
        ktx2_test::count_refused_damages(file, [](bool is_right) { ASSERT_TRUE(is_right); });
    EXPECT_GT(refused, file.size());
  }
}

}  // namespace
}  // namespace fire3dv::scene::ktx2
