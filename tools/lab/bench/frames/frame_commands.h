// Commands of fire3dv-bench that draw frames, and their options: frame, images and cameras.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/gpu/device/async_compute.h"
#include "renderer/settings/draw_settings.h"

namespace fire3dv::bench {

// Rendering options, named like the renderer's own.
struct DrawOptions {
  std::string resolution = "1920x1080";
  uint32_t width = 1920, height = 1080;
  std::string device, async_compute = "auto";
  bool require_gpu = false;
  bool validation = false;
  settings::DrawSettings settings;
};
void add_draw_options(CLI::App& app, DrawOptions& options);
Result<void> check_draw_options(DrawOptions& options);
gpu::AsyncCompute async_compute(const DrawOptions& options);

// Options of `fire3dv-bench frame`.
struct FrameOptions {
  DrawOptions draw;
  std::string sizes = "223K,550K,1M,2M,4M,7M,14M,28M";
  std::vector<uint64_t> triangles;  // parsed from sizes
  uint32_t bodies = 0;              // 0: depends on size
  uint32_t lights = 2;
  uint32_t texture_side = 1024;
  uint32_t frames = 100, warm_up = 30;
  bool gui = false;
  float gui_scale = 1;
  std::string conditions = "all";  // all, product, paper or rays
  uint32_t ray_effect_rays = 4;    // in a pixel
  std::filesystem::path out = "docs/benchmarks", images;
  std::string name = "frame";  // base name of files in `out`
  std::string command;         // command line as typed
};
void add_frame_options(CLI::App& app, FrameOptions& options);
Result<void> check_frame_options(FrameOptions& options);

// Parses "223K", "28M" or plain digits, up to 200 M.
Result<uint64_t> parse_triangles(std::string_view text);
std::string triangles_text(uint64_t triangles);

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

// Throughput of many cameras in one scene or in worlds of it, in images per second.
struct CamerasOptions {
  DrawOptions draw;
  std::filesystem::path scene;
  std::vector<uint32_t> cameras{1, 8, 64};
  std::string outputs = "color,depth";
  std::string to;         // URI of a running fire3dv that renders them; empty: rendered in this process
  uint32_t worlds = 1;    // copies of the scene with poses of their own
  bool resident = false;  // images stay on the device
  bool passes = false;    // prints the GPU time of each pass
  uint32_t frames = 30, warm_up = 3;
};
void add_cameras_options(CLI::App& app, CamerasOptions& options);

int run_cameras(const CamerasOptions& options);

// The same for a running fire3dv that sends the images to a lockstep client. Connects to options.to, which
// must show the scene that the options name.
Result<void> measure_served(const CamerasOptions& options);

}  // namespace fire3dv::bench
