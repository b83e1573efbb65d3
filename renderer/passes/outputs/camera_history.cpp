#include "renderer/passes/outputs/camera_history.h"

#include <algorithm>

namespace fire3dv::passes {
namespace {

constexpr long kOfPool = 1;  // reference that OutputsPass has to each buffer

}  // namespace

bool can_replace_depth(const CameraHistory& history, glm::uvec2 image_px) {
  return history.depth.use_count() == 1 + kOfPool && history.depth_size == image_px;
}

ReplacedMemory replaced_by(std::span<const CameraHistory* const> histories, glm::uvec2 image_px) {
  ReplacedMemory replaced;
  for (const CameraHistory* const history : histories) {
    replaced.depths += can_replace_depth(*history, image_px) ? 1 : 0;
    const auto sharers = std::ranges::count_if(
        histories, [&](const CameraHistory* const other) { return other->poses == history->poses; });
    replaced.poses |= history->poses && history->poses.use_count() == sharers + kOfPool;
  }
  return replaced;
}

}  // namespace fire3dv::passes
