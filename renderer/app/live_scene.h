// The scene that is shown, as streams edit it.
#pragma once

#include <string>
#include <vector>

#include "renderer/app/camera_rig.h"
#include "renderer/passes/scene_renderer.h"
#include "renderer/scene/scene_edits.h"
#include "renderer/state/edit_book.h"

namespace fire3dv::app {

class LiveScene {
 public:
  // All is borrowed, and of this scene.
  LiveScene(const scene::Scene& scene, state::PoseState& poses, passes::SceneRenderer& renderer,
            CameraRig& camera);

  // Between two frames: does what streams have asked for since the last call. Returns true when there is a
  // new pose frame to show, which had waited for that.
  bool follow();

  const scene::SceneEdits& edits() const { return edits_; }
  const state::EditFaults& faults() const { return book_.faults(); }
  // Sentences for the user since the last call.
  std::vector<std::string> take_notes();

 private:
  const scene::Scene& scene_;
  state::PoseState& poses_;
  state::EditBook book_;
  scene::SceneEdits edits_;
  uint64_t bindings_seen_ = 0;
};

}  // namespace fire3dv::app
