// Test of benchmark statistics and report files (CSV, Markdown).
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tools/lab/bench/frames/frame_commands.h"
#include "tools/lab/bench/report/report.h"

namespace fire3dv::bench {
namespace {

TEST(Statistics, OfKnownNumbers) {
  const Summary summary = summarise({4, 2, 9, 4, 5, 4, 5, 7});
  EXPECT_EQ(summary.count, 8u);
  EXPECT_DOUBLE_EQ(summary.median, 4.5);
  EXPECT_DOUBLE_EQ(summary.mean, 5);
  EXPECT_NEAR(summary.deviation, 2.1380899, 1e-6);  // sum of squares 32, divided by 7
  EXPECT_NEAR(summary.p95, 8.3, 1e-9);              // 0.95 of the way through seven steps: 6.65
  EXPECT_NEAR(summary.p99, 8.86, 1e-9);
  EXPECT_NEAR(summary.p999, 8.986, 1e-9);
  EXPECT_DOUBLE_EQ(summary.least, 2);
  EXPECT_DOUBLE_EQ(summary.most, 9);
}

TEST(Statistics, OfOneAndOfNone) {
  const Summary one = summarise({3});
  EXPECT_DOUBLE_EQ(one.median, 3);
  EXPECT_DOUBLE_EQ(one.p95, 3);
  EXPECT_DOUBLE_EQ(one.deviation, 0);
  EXPECT_EQ(summarise({}).count, 0u);
}

TEST(Stages, AddUpToTheWholeFrame) {
  gpu::FrameTimes times;
  times.passes = {{"tlas", 1, false},   {"clear", 2, false},  {"raster", 4, false}, {"cull", 8, false},
                  {"shade", 16, false}, {"trace", 32, false}, {"fxaa", 64, false}};
  times.total_ms = 130;
  const Result<StageTimes> stages = stage_times(times);
  ASSERT_TRUE(stages) << stages.error().message;
  EXPECT_DOUBLE_EQ(stages->ms[static_cast<size_t>(Stage::tlas)], 1);
  EXPECT_DOUBLE_EQ(stages->ms[static_cast<size_t>(Stage::raster)], 6);
  EXPECT_DOUBLE_EQ(stages->ms[static_cast<size_t>(Stage::shadow)], 32);
  EXPECT_DOUBLE_EQ(stages->main_pass_ms(), 8 + 6 + 16);
  EXPECT_DOUBLE_EQ(stages->between_ms, 3);
  EXPECT_DOUBLE_EQ(stages->frame_ms, 130);
}

TEST(Stages, AsyncStagesTakeNoFrameTime) {
  gpu::FrameTimes times;
  times.passes = {{"tlas", 4, true}, {"raster", 8, false}, {"tlas wait", 1, false}};
  times.total_ms = 10;
  const Result<StageTimes> stages = stage_times(times);
  ASSERT_TRUE(stages) << stages.error().message;
  EXPECT_DOUBLE_EQ(stages->ms[static_cast<size_t>(Stage::tlas)], 4);
  EXPECT_DOUBLE_EQ(stages->ms[static_cast<size_t>(Stage::tlas_wait)], 1);
  EXPECT_DOUBLE_EQ(stages->aside_ms, 4);
  EXPECT_DOUBLE_EQ(stages->between_ms, 1);
}

TEST(Stages, UnknownPassIsRefused) {
  gpu::FrameTimes times;
  times.passes = {{"tlas", 1, false}, {"a pass of tomorrow", 1, false}};
  const Result<StageTimes> stages = stage_times(times);
  ASSERT_FALSE(stages);
  EXPECT_NE(stages.error().message.find("\"a pass of tomorrow\""), std::string::npos)
      << stages.error().message;
}

TEST(Options, NumbersOfTriangles) {
  const auto number = [](const char* text) {
    const Result<uint64_t> triangles = parse_triangles(text);
    return triangles ? *triangles : 0;
  };
  EXPECT_EQ(number("223K"), 223'000u);
  EXPECT_EQ(number("28M"), 28'000'000u);
  EXPECT_EQ(number("1500"), 1500u);
  EXPECT_EQ(number("200M"), 200'000'000u);
  for (const char* wrong :
       {"", "K", "12G", "1.5M", "-5K", "999", "201M", "18446744073709551615M", "7 M", "0x10K"})
    EXPECT_EQ(number(wrong), 0u) << wrong;
  for (const uint64_t triangles : {223'000u, 28'000'000u, 1'001u})
    EXPECT_EQ(number(triangles_text(triangles).c_str()), triangles);
}

TEST(Options, RefuseUnmeasurableSettings) {
  const auto refused = [](auto change) {
    FrameOptions options;
    change(options);
    const Result<void> checked = check_frame_options(options);
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_EQ(refused([](FrameOptions&) {}), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.sizes = "1M,,2M"; }), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.sizes = "1M,"; }), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.draw.resolution = "1920"; }), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.draw.resolution = "0x10"; }), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.name = "../frame"; }), "");
  EXPECT_NE(refused([](FrameOptions& o) { o.name = ""; }), "");
}

FrameSamples samples_of(double whole_frame_ms, size_t count) {
  FrameSamples samples;
  for (size_t i = 0; i < count; ++i) {
    StageTimes times;
    times.ms[static_cast<size_t>(Stage::raster)] = whole_frame_ms / 2;
    samples.frame_ms.push_back(whole_frame_ms + static_cast<double>(i));
    samples.stages.push_back(times);
    samples.cpu_ms.push_back(0.25);
    samples.pose_age_ms.push_back(0.5);
    samples.interval_ms.push_back(whole_frame_ms);
  }
  samples.memory.resident_bytes = 3 << 20;
  return samples;
}

Report report_of_two_scenes() {
  Report report;
  report.command = "fire3dv-bench frame";
  report.device = "A \"fast\" <device> & more";
  report.commit = "0123456789ab";
  report.width = 640;
  report.height = 480;
  report.samples = 4;
  for (const uint64_t triangles : {223'000u, 7'000'000u}) {
    SceneReport scene;
    scene.name = triangles_text(triangles);
    scene.triangles = triangles;
    scene.bodies = 9;
    const double ms = static_cast<double>(triangles) * 1e-6;
    for (const Condition& condition :
         {Condition{kProduct, settings::Cull::automatic, true, settings::LevelsOfDetail::automatic},
          {kProductMain, settings::Cull::automatic, false, settings::LevelsOfDetail::automatic},
          {kPaper, settings::Cull::off, true, settings::LevelsOfDetail::off},
          {kPaperMain, settings::Cull::off, false, settings::LevelsOfDetail::off}})
      scene.runs.push_back(summarise_run(condition, samples_of(ms, 5)));
    report.scenes.push_back(std::move(scene));
  }
  return report;
}

TEST(Csv, QuantitiesHaveRows) {
  std::istringstream text(csv_of(report_of_two_scenes()));
  std::string line;
  std::getline(text, line);
  const auto columns = [](const std::string& row) {
    size_t count = 1;
    bool quoted = false;
    for (const char c : row) {
      if (c == '"') quoted = !quoted;
      count += c == ',' && !quoted;
    }
    return count;
  };
  const size_t expected = columns(line);
  EXPECT_EQ(expected, 18u);
  bool found = false;
  size_t rows = 0;
  while (std::getline(text, line)) {
    ++rows;
    EXPECT_EQ(columns(line), expected) << line;
    EXPECT_EQ(line.find("\"A \"\"fast\"\" <device> & more\""), 0u) << line;
    found |=
        line.find("7M,7000000,9,\"product\",whole frame,ms,5,9,10.8,9,1.58114,7,11") != std::string::npos;
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(rows, 2 * (2 + 4 * (2 + kStages + 5 + 2) + 2));  // two of the four conditions have a main pass
}

TEST(Markdown, NamesTheMeasurement) {
  const std::string text = markdown_of(report_of_two_scenes());
  EXPECT_NE(text.find("| 7M | 7000000 | 9 | 9.000 | 10.8 |"), std::string::npos) << text;
  EXPECT_NE(text.find("Commit: 0123456789ab"), std::string::npos);
  EXPECT_NE(text.find("9.000 ± 1.581"), std::string::npos);
  for (const char* stage : {"TLAS", "cull", "raster", "shadow", "shading", "post", "GUI"})
    EXPECT_NE(text.find(std::string("| ") + stage + " |"), std::string::npos) << stage;
  // All rows of a table have as many cells as its head.
  std::istringstream lines(text);
  size_t cells = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto bars = static_cast<size_t>(std::count(line.begin(), line.end(), '|'));
    if (line.empty() || line[0] != '|') {
      cells = 0;
    } else if (cells == 0) {
      cells = bars;
    } else {
      EXPECT_EQ(bars, cells) << line;
    }
  }
}

}  // namespace
}  // namespace fire3dv::bench
