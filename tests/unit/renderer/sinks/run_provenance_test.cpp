// Unit test of the provenance of runs: its text, hostile texts, differences, and its way through PNG files.
#include "renderer/sinks/run_provenance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "base/build_info.h"
#include "renderer/sinks/png.h"

namespace fire3dv::sinks {
namespace {

RunProvenance example() {
  RunProvenance run;
  run.command = "dataset";
  run.build = {{"version", "1.2.3"}, {"commit", "abc"}, {"build_id", "00ff"}};
  run.machine = {{"device", "llvmpipe"}, {"driver", "Mesa \"22\"\n"}, {"cpu", "Größe"}};
  run.files = {{"recording", "a b.mcap"}};
  run.inputs = {{"scene", "0123"}, {"cameras", "left\nright\n"}};
  run.options = {{"size", "160x90"}, {"camera", "left"}, {"camera", "right"}, {"stereo-pairs", ""}};
  return run;
}

std::string text_of_example() {
  return encode_provenance(example()).value();
}

TEST(RunProvenance, ReturnsFromItsText) {
  const std::string text = text_of_example();
  for (const char c : text) EXPECT_TRUE(c >= ' ' && c < 0x7f);
  const auto back = decode_provenance(text);
  ASSERT_TRUE(back.ok()) << back.error().message;
  RunProvenance wanted = example();
  for (auto* values : {&wanted.machine, &wanted.inputs}) {  // control characters of untrusted names
    for (auto& [name, value] : *values) {
      for (char& c : value) c = c == '\n' ? '?' : c;
    }
  }
  EXPECT_EQ(*back, wanted);
  EXPECT_EQ(encode_provenance(*back).value(), text_of_example());
}

TEST(RunProvenance, KnowsItsBuild) {
  const RunProvenance::Values build = this_build();
  ASSERT_TRUE(find_value(build, "version"));
  EXPECT_EQ(*find_value(build, "version"), kVersion);
  ASSERT_TRUE(find_value(build, "build_id"));
  EXPECT_GE(find_value(build, "build_id")->size(), 16u);
  EXPECT_EQ(this_build(), build);
}

TEST(RunProvenance, RefusesHostileTexts) {
  const std::string good = text_of_example();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::string deep = std::string(20000, '[') + std::string(20000, ']');
  for (const std::string& text :
       {std::string(), std::string("x"), std::string("[]"), good.substr(0, good.size() - 1),
        std::string(kMaxProvenanceBytes + 1, ' '), deep, "{\"version\":" + deep + "}",
        with("\"version\":1", "\"version\":2"), with("\"version\":1", "\"version\":\"1\""),
        with("\"command\":\"dataset\"", "\"command\":7"), with("[\"size\",\"160x90\"]", "[\"size\"]"),
        with("[\"size\",\"160x90\"]", "[\"size\",3]"), with("\"scene\":\"0123\"", "\"scene\":{}")}) {
    const auto decoded = decode_provenance(text);
    EXPECT_FALSE(decoded.ok()) << text.substr(0, 100);
    if (decoded.ok()) continue;
    EXPECT_NE(decoded.error().message.find("its provenance"), std::string::npos);
  }
}

TEST(RunProvenance, IsLeftOutWhenTooLong) {
  RunProvenance run = example();
  for (int i = 0; i < 4000; ++i) run.options.emplace_back("object", "a node with a long name");
  EXPECT_FALSE(encode_provenance(run).has_value());
}

TEST(RunProvenance, NamesTheFirstDifference) {
  const RunProvenance::Values values = example().options;
  EXPECT_EQ(first_difference(values, values), std::nullopt);
  RunProvenance::Values other = values;
  other[2].second = "centre";
  EXPECT_EQ(first_difference(values, other), "camera is left, right in the file and left, centre here");
  other = values;
  other.pop_back();
  EXPECT_EQ(first_difference(values, other), "stereo-pairs is set in the file and not set here");
  EXPECT_EQ(first_difference(other, values), "stereo-pairs is not set in the file and set here");
}

TEST(RunProvenance, TravelsInPngFiles) {
  FrameImage image;
  image.width = 2;
  image.height = 1;
  image.rgba8.assign(8, 255);
  RunProvenance run = example();
  for (int i = 0; i < 500; ++i) run.options.emplace_back("object", std::to_string(i));  // more than 4 KiB
  image.run_provenance = std::make_shared<const std::string>(encode_provenance(run).value());
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes.ok());
  const auto back = decode_png(*bytes);
  ASSERT_TRUE(back.ok() && back->image.run_provenance);
  EXPECT_EQ(*back->image.run_provenance, *image.run_provenance);
}

double least_microseconds(const FrameImage& image) {
  double least = 1e9;
  for (int i = 0; i < 30; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(encode_png(image).ok());
    const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
    least = std::min(least, time.count());
  }
  return least;
}

// The text of a tiny image, against the encoding of one of 640x480, which is a part of its cost alone.
TEST(RunProvenance, CostsLittle) {
  FrameImage image;
  image.width = 640;
  image.height = 480;
  for (uint32_t i = 0; i < 640 * 480; ++i)
    image.rgba8.insert(image.rgba8.end(), {static_cast<uint8_t>(i / 640), static_cast<uint8_t>(i), 7, 255});
  const double frame_us = least_microseconds(image);
  image.width = image.height = 1;
  image.rgba8.resize(4);
  const double without_us = least_microseconds(image);
  image.run_provenance = std::make_shared<const std::string>(text_of_example());
  const double text_us = least_microseconds(image) - without_us;
  std::printf("PNG of 640x480: %.0f us; provenance: %.1f us, %.3f %%\n", frame_us, text_us,
              100 * text_us / frame_us);
  EXPECT_LE(image.run_provenance->size(), 2048u);  // times depend on the machine's load
}

}  // namespace
}  // namespace fire3dv::sinks
