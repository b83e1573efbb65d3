// `fire3dv-bench cameras`: how many images a second many cameras of one scene give, in host memory.
#pragma once

#include "tools/bench/frame_options.h"

namespace fire3dv::bench {

struct CamerasOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  std::vector<uint32_t> cameras{1, 8, 64};
  std::string outputs = "color,depth";
  std::string to;  // URI of a fire3dv that is asked for them; empty: they are drawn here
  uint32_t frames = 30, warm_up = 3;
};
void add_cameras_options(CLI::App& app, CamerasOptions& options);

// The exit code: 0, or 1 after an error that was printed.
int run_cameras(const CamerasOptions& options);

}  // namespace fire3dv::bench
