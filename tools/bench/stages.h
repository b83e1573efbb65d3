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

enum class Stage : uint8_t { poses, tlas, cull, raster, shadow, shading, post, gui, readback };
constexpr size_t kStages = 9;
const char* stage_name(Stage stage);

std::optional<Stage> stage_of(std::string_view pass);

struct StageTimes {
  std::array<double, kStages> ms{};
  double between_ms =
      0;  // of the whole frame, what no pass has: barriers, and where passes overlap, less than 0
  double frame_ms = 0;
  double main_pass_ms() const;  // cull, raster and shading
};
Result<StageTimes> stage_times(const gpu::FrameTimes& times);

}  // namespace fire3dv::bench
