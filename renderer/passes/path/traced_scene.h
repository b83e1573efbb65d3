// Scene state of a path-traced image that refines over several frames: decides whether it may go on.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::passes {

class TracedScene {
 public:
  void set(const state::PoseState& poses, const scene::EditRevisions& edits);
  // True if poses and edits are those of set(). A stream that publishes the same poses again changes nothing.
  bool equals(const state::PoseState& poses, const scene::EditRevisions& edits);

 private:
  uint64_t revision_ = 0;  // of poses known to be equal
  scene::EditRevisions edits_;
  std::vector<state::NodeDrive> drives_;
  std::vector<float> morph_weights_;
  std::vector<std::vector<wire::Affine3x4>> stream_poses_;
};

}  // namespace fire3dv::passes
