// `fire3dv-bench cameras`: throughput of many cameras in one scene, in images per second in host memory.
#pragma once

#include "tools/lab/bench/frames/frame_options.h"

namespace fire3dv::bench {

struct CamerasOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  std::vector<uint32_t> cameras{1, 8, 64};
  std::string outputs = "color,depth";
  std::string to;  // URI of a running fire3dv that renders them; empty: rendered in this process
  uint32_t frames = 30, warm_up = 3;
};
void add_cameras_options(CLI::App& app, CamerasOptions& options);

// Returns the exit code: 0, or 1 after a printed error.
int run_cameras(const CamerasOptions& options);

}  // namespace fire3dv::bench
