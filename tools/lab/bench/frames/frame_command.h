// `fire3dv-bench frame` and `fire3dv-bench images`.
#pragma once

#include "tools/lab/bench/frames/frame_options.h"

namespace fire3dv::bench {

struct ImageOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  uint32_t frames = 30, warm_up = 5;
  std::filesystem::path png;  // file for the last image; empty: none
};
void add_image_options(CLI::App& app, ImageOptions& options);

// Both return the exit code: 0, or 1 after a printed error.
int run_frames(const FrameOptions& options);
// Measures the time from new poses to the image in host memory for one glTF file, for comparison with other
// programs.
int run_images(const ImageOptions& options);

}  // namespace fire3dv::bench
