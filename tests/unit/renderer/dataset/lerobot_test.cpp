// Test of the parts of LeRobot data sets: Parquet files byte by byte, depth codes, statistics, and lists of
// other programs.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/dataset/labels/line_check.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/dataset/lerobot/depth_codes.h"
#include "renderer/dataset/lerobot/statistics.h"
#include "renderer/dataset/lerobot/videos.h"
#include "renderer/dataset/parquet/compact_writer.h"
#include "renderer/dataset/parquet/parquet_file.h"

namespace fire3dv::dataset {
namespace {

std::string text_of(const std::vector<uint8_t>& bytes) {
  return {bytes.begin(), bytes.end()};
}

TEST(Parquet, CompactProtocolByteByByte) {
  std::vector<uint8_t> bytes;
  CompactWriter writer(bytes);
  writer.add(1, int32_t{-3});
  writer.add(4, std::string_view("ab"));
  writer.begin_list(5, CompactType::i32, 2);
  writer.append(int32_t{1});
  writer.append(int32_t{300});
  writer.begin_struct(7);
  writer.add(2, int64_t{64});
  writer.end();
  writer.end();
  EXPECT_EQ(bytes, (std::vector<uint8_t>{0x15, 5, 0x38, 2, 'a', 'b', 0x19, 0x25, 2, 0xd8, 4, 0x2c, 0x26, 0x80,
                                         1, 0, 0}));
  bytes.clear();
  CompactWriter longer(bytes);
  longer.begin_list(1, CompactType::binary, 20);
  EXPECT_EQ(bytes, (std::vector<uint8_t>{0x19, 0xf8, 20}));
}

// Levels of [[1, 2, 3], [4, 5, 6]] in each of two rows, from the format's documentation.
TEST(Parquet, LevelsOfNestedLists) {
  std::vector<double> values(12);
  const std::string file = text_of(encode_parquet({{"x", {2, 3}, values}}, 2, {}));
  // Runs of 0, 2 2, 1, 2 2 and again; each a count times two, and the level.
  const std::string repetition("\x10\0\0\0\x02\0\x04\x02\x02\x01\x04\x02\x02\0\x04\x02\x02\x01\x04\x02", 20);
  const std::string definition("\x02\0\0\0\x18\x05", 6);
  EXPECT_NE(file.find(repetition + definition + std::string(96, '\0')), std::string::npos);
  EXPECT_EQ(file.substr(0, 4), "PAR1");
  EXPECT_EQ(file.substr(file.size() - 4), "PAR1");
}

TEST(Parquet, LongColumnsHaveSeveralPages) {
  constexpr uint64_t kRows = 300'000;
  std::vector<int64_t> values(kRows);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<int64_t>(i);
  const auto file = encode_parquet({{"i", {}, values}}, kRows, {});
  EXPECT_GT(file.size(), 8 * kRows);
  EXPECT_LT(file.size(), 8 * kRows + 500);
  EXPECT_EQ(file, encode_parquet({{"i", {}, values}}, kRows, {}));
}

TEST(DepthCodes, AreThoseOfLerobot) {
  const DepthCodes codes;  // 0.01 m to 10 m, shift 3.5 m
  // round(4095 * (log(d + 3.5) - log(3.51)) / (log(13.5) - log(3.51)))
  const std::vector<float> depth_m{0.01f,
                                   10.0f,
                                   0.0f,
                                   50.0f,
                                   std::numeric_limits<float>::infinity(),
                                   std::numeric_limits<float>::quiet_NaN(),
                                   1.0f,
                                   5.0f};
  EXPECT_EQ(codes.encode(depth_m), (std::vector<uint16_t>{0, 4095, 0, 4095, 4095, 0, 755, 2689}));
  for (const double m : {0.01, 0.2, 1.0, 5.0, 10.0}) {
    const uint16_t code = codes.encode(std::vector<float>{static_cast<float>(m)}).front();
    EXPECT_NEAR(codes.decode(code), m, 0.5 * (m + 3.5) * std::log(13.5 / 3.51) / 4095 + 1e-6) << m;
  }
  Description description;
  description.depth_unit_mm = 0.1;
  description.episode.has_linear_depth = true;
  const DepthCodes steps = DepthCodes::of(description);
  EXPECT_EQ(steps.encode(std::vector<float>{0.0f, 0.0001f, 0.01f, 0.4095f, 1.0f}),
            (std::vector<uint16_t>{0, 1, 100, 4095, 4095}));
  EXPECT_NEAR(steps.decode(100), 0.01, 1e-12);
}

// Numbers of numpy.quantile(a, q).
TEST(Statistics, AreThoseOfNumpy) {
  const auto statistics = statistics_of(std::vector<double>{3, 10, 1, 10, 2, 40, 4, 20}, 2);
  const std::vector<std::vector<double>> wanted{
      {1, 10},      {4, 40},     {2.5, 20},   {1.1180339887498949, 12.24744871391589},
      {1.03, 10.0}, {1.3, 10.0}, {2.5, 15.0}, {3.7, 34.0},
      {3.97, 39.4}};
  for (size_t i = 0; i < wanted.size(); ++i) {
    for (size_t k = 0; k < 2; ++k)
      EXPECT_NEAR(statistics.values[i][k], wanted[i][k], 1e-12) << kStatisticNames[i];
  }
  EXPECT_EQ(statistics.count, 4u);
  PixelCounts counts(1, 256);
  for (const size_t value : {10u, 10u, 40u, 20u}) counts.add(0, value);
  const auto pixels = counts.statistics([](size_t value) { return static_cast<double>(value); }, 1);
  for (size_t i = 0; i < wanted.size(); ++i)
    EXPECT_NEAR(pixels.values[i][0], wanted[i][1], 1e-12) << kStatisticNames[i];
}

TEST(Lerobot, CamerasOfOneNameHaveKeysOfTheirOwn) {
  Description description;
  description.cameras = {"front", "a/b"};
  EXPECT_EQ(camera_keys(description)[1].color, "observation.images.a_b");
  for (const std::vector<std::string>& cameras :
       {std::vector<std::string>{"auto", "auto"}, {"front", "front_depth"}, {"a/b", "a b"}}) {
    description.cameras = cameras;
    std::vector<std::string> names;
    for (const CameraKeys& keys : camera_keys(description))
      names.insert(names.end(), {keys.color, keys.depth});
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end()) << cameras[1];
    EXPECT_TRUE(names.front().starts_with("observation.images.00_")) << names.front();
  }
}

TEST(Lerobot, LinesHaveTheStateOfTheDescription) {
  Description description;
  description.width = description.height = 16;
  description.cameras = {"front"};
  description.format = kLerobot;
  description.episode.fps = 30;
  description.episode.state_names = {"a", "b"};
  const auto written = as_written(description);
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written->episode.state_names, description.episode.state_names);
  EXPECT_EQ(written->episode.fps, 30u);
  auto line = nlohmann::json::parse(R"({"cam_K":[1,0,0,0,1,0,0,0,1],"cam_R_w2c":[1,0,0,0,1,0,0,0,1],
    "cam_t_w2c":[0,0,0],"brightness":3,"instances":[],"keypoints":[],"state":[1,2.5]})");
  EXPECT_TRUE(is_image_line(line, description));
  for (const char* state : {"[1]", "[1,2,3]", "[1,\"x\"]", "[1,null]", "3", "[1,1e300]"}) {
    line["state"] = nlohmann::json::parse(state);
    EXPECT_FALSE(is_image_line(line, description)) << state;
  }
  const auto layout = make_layout(kLerobot);
  ASSERT_TRUE(layout);
  description.width = 15;
  EXPECT_FALSE(layout->check(description).ok());
  description.episode.fps = 0;  // dataset.json that another program has changed
  EXPECT_FALSE(layout->check(description).ok());
}

}  // namespace
}  // namespace fire3dv::dataset
