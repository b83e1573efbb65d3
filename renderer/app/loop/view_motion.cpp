#include "renderer/app/loop/view_motion.h"

namespace fire3dv::app {

bool ViewMotion::update(const state::PoseState& poses, const scene::EditRevisions& edits,
                        const glm::mat4& clip_from_world, Clock::time_point now) {
  const bool is_first = !clip_from_world_;
  if (scene_.equals(poses, edits) && clip_from_world_ == clip_from_world) return moves(now);
  scene_.set(poses, edits);
  clip_from_world_ = clip_from_world;
  if (!is_first) moved_ = now;
  return moves(now);
}

}  // namespace fire3dv::app
