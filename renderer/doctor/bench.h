// Frame times of a generated scene, for tables that people send in.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/doctor/facts.h"

namespace fire3dv::doctor {

struct BenchSize {
  uint32_t width = 0, height = 0;
};
// Sizes of the columns.
std::vector<BenchSize> bench_sizes();

// Draws the scene in each size on a device. For a child process; failures are exceptions. Returns
// {"triangles", "ms": [median of each size]}: from the start of recording to the pixels in host memory.
nlohmann::json run_bench(uint32_t device);

struct BenchRow {
  std::string device, driver;
  Trial trial;
  uint64_t triangles = 0;
  std::vector<double> ms;
};
// Header and rows of a Markdown table.
std::string bench_table(const std::vector<BenchRow>& rows);

}  // namespace fire3dv::doctor
