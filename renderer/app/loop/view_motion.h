// Motion of a window's view: poses, edits or the camera change from image to image. Where images in motion
// are reduced, a full one is due at rest.
#pragma once

#include <chrono>
#include <glm/glm.hpp>
#include <optional>

#include "renderer/passes/path/traced_scene.h"

namespace fire3dv::app {

class ViewMotion {
 public:
  using Clock = std::chrono::steady_clock;
  // Streams of 4 Hz and more are in motion between their frames.
  static constexpr auto kRestTime = std::chrono::milliseconds(300);

  // Notes what the next image shows. Returns true if the view moves now, or did a short time ago. The first
  // view stands. A stream that publishes the same poses again moves nothing.
  bool update(const state::PoseState& poses, const scene::EditRevisions& edits,
              const glm::mat4& clip_from_world, Clock::time_point now);
  // The last image was drawn with these settings.
  void note_image(bool is_reduced) { is_reduced_ = is_reduced; }
  // True if the last image is reduced, and the view has come to rest.
  bool needs_image_at_rest(Clock::time_point now) const { return is_reduced_ && !moves(now); }

 private:
  bool moves(Clock::time_point now) const { return moved_ && now - *moved_ < kRestTime; }

  passes::TracedScene scene_;
  std::optional<glm::mat4> clip_from_world_;
  std::optional<Clock::time_point> moved_;
  bool is_reduced_ = false;
};

}  // namespace fire3dv::app
