// Which stage of the report each pass of a frame belongs to. A pass that is not in the table is an error, so
// that none is lost from the report.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "protocol/error.h"
#include "renderer/gpu/frame_ring.h"

namespace fire3dv::bench {

// tlas_wait: how long the main queue stands still for what is built on the side queue.
enum class Stage : uint8_t { poses, tlas, tlas_wait, cull, raster, shadow, shading, post, gui, readback };
constexpr size_t kStages = 10;
const char* stage_name(Stage stage);

std::optional<Stage> stage_of(std::string_view pass);

struct StageTimes {
  std::array<double, kStages> ms{};
  double aside_ms = 0;    // of the stages' times, what ran on the side queue, beside the others
  double between_ms = 0;  // of the whole frame, what no pass of the main queue has: barriers
  double frame_ms = 0;    // from the first pass's begin to the last one's end
  double main_pass_ms() const;  // cull, raster and shading
};
Result<StageTimes> stage_times(const gpu::FrameTimes& times);

}  // namespace fire3dv::bench
