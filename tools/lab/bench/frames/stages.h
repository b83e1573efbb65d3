// Map from render passes to stages of the report. An unknown pass is an error, so that no time is lost.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "protocol/base/error.h"
#include "renderer/gpu/frame_ring.h"

namespace fire3dv::bench {

// tlas_wait: time that the graphics queue waits for the async compute queue.
enum class Stage : uint8_t { poses, tlas, tlas_wait, cull, raster, shadow, shading, post, gui, readback };
constexpr size_t kStages = 10;
const char* stage_name(Stage stage);

std::optional<Stage> stage_of(std::string_view pass);

struct StageTimes {
  std::array<double, kStages> ms{};
  double aside_ms = 0;          // stage time on the async compute queue, overlapped with other stages
  double between_ms = 0;        // frame time on the graphics queue outside all passes: barriers
  double frame_ms = 0;          // from the start of the first pass to the end of the last one
  double main_pass_ms() const;  // cull, raster and shading
};
Result<StageTimes> stage_times(const gpu::FrameTimes& times);

}  // namespace fire3dv::bench
