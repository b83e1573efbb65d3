// Commands of fire3dv-bench that draw frames: frame, images and cameras.
#pragma once

#include "protocol/base/error.h"
#include "tools/lab/bench/frames/frame_options.h"

namespace fire3dv::bench {

struct ImageOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  uint32_t frames = 30, warm_up = 5;
  std::filesystem::path png;  // file for the last image; empty: none
};
void add_image_options(CLI::App& app, ImageOptions& options);

// Commands return the exit code: 0, or 1 after a printed error.
int run_frames(const FrameOptions& options);
// Measures the time from new poses to the image in host memory for one glTF file, for comparison with other
// programs.
int run_images(const ImageOptions& options);

// Throughput of many cameras in one scene, in images per second in host memory.
struct CamerasOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  std::vector<uint32_t> cameras{1, 8, 64};
  std::string outputs = "color,depth";
  std::string to;  // URI of a running fire3dv that renders them; empty: rendered in this process
  uint32_t frames = 30, warm_up = 3;
};
void add_cameras_options(CLI::App& app, CamerasOptions& options);

int run_cameras(const CamerasOptions& options);

// The same for a running fire3dv that sends the images to a lockstep client. Connects to options.to, which
// must show the scene that the options name.
Result<void> measure_served(const CamerasOptions& options);

}  // namespace fire3dv::bench
