// `fire3dv-bench frame` and `fire3dv-bench images`.
#pragma once

#include "tools/bench/frame_options.h"

namespace fire3dv::bench {

struct ImageOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  uint32_t frames = 30, warm_up = 5;
  std::filesystem::path png;  // of the last image; empty: none
};
void add_image_options(CLI::App& app, ImageOptions& options);

// Both return the exit code: 0, or 1 after an error that was printed.
int run_frames(const FrameOptions& options);
// Times from new poses to the image in memory, of one glTF file: what other programs are compared by.
int run_images(const ImageOptions& options);

}  // namespace fire3dv::bench
