// Command line of `fire3dv-bench frame`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"
#include "renderer/gpu/device/queue_choice.h"
#include "renderer/passes/scene_renderer.h"

namespace fire3dv::bench {

// Rendering options, named like the renderer's own.
struct DrawOptions {
  std::string resolution = "1920x1080";
  uint32_t width = 1920, height = 1080;
  std::string device, async_compute = "auto";
  bool validation = false;
  uint32_t samples = 4;
  std::string raster = "auto", cull = "on", levels_of_detail = "auto", shadows = "auto",
              shadow_rays = "hybrid", fxaa = "on";
};
void add_draw_options(CLI::App& app, DrawOptions& options);
Result<void> check_draw_options(DrawOptions& options);
gpu::AsyncCompute async_compute(const DrawOptions& options);
passes::DrawSettings draw_settings(const DrawOptions& options);

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
  std::string conditions = "all";  // all, product or paper
  std::filesystem::path out = "docs/benchmarks", images;
  std::string name = "frame";  // base name of files in `out`
  std::string command;         // command line as typed
};
void add_frame_options(CLI::App& app, FrameOptions& options);
Result<void> check_frame_options(FrameOptions& options);

// Parses "223K", "28M" or plain digits, up to 200 M.
Result<uint64_t> parse_triangles(std::string_view text);
std::string triangles_text(uint64_t triangles);

}  // namespace fire3dv::bench
