// Results of a benchmark run and their output files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tools/lab/bench/frames/frame_bench.h"
#include "tools/lab/bench/report/statistics.h"

namespace fire3dv::bench {

struct RunSummary {
  std::string condition;
  bool shadows = true;
  Summary frame_ms, staged_frame_ms;  // timed as a whole; timed per stage, like the following
  Summary main_pass_ms, aside_ms, between_ms, cpu_ms, pose_age_ms, interval_ms;
  std::array<Summary, kStages> stage_ms;
  MemoryUse memory;
};
RunSummary summarise_run(const Condition& condition, const FrameSamples& samples);

struct SceneReport {
  std::string name;  // as requested: "7M"
  uint64_t triangles = 0, unique_triangles = 0;
  uint32_t bodies = 0;
  double make_s = 0, load_s = 0;
  std::vector<RunSummary> runs;

  const RunSummary* run(const std::string& condition) const;  // null: not run
};

struct Report {
  std::string command, commit, date, device, driver;
  uint32_t width = 0, height = 0, samples = 0, lights = 0, texture_side = 0, warm_up = 0, frames = 0;
  std::string raster, shadows;
  bool fxaa = true;
  std::vector<SceneReport> scenes;
};

inline constexpr const char* kProduct = "product";
inline constexpr const char* kProductMain = "product, no shadows";
inline constexpr const char* kPaper = "paper";
inline constexpr const char* kPaperMain = "paper, no shadows";
// Of --conditions rays, beside kProduct: names of ray effects.
inline constexpr const char* kRayConditions[] = {"reflections", "ao", "bounce", "reflections,ao", "all"};

std::string markdown_of(const Report& report);
std::string csv_of(const Report& report);

// Writes NAME.md and NAME.csv to an existing folder.
Result<void> write_report(const Report& report, const std::filesystem::path& folder, const std::string& name);

}  // namespace fire3dv::bench
