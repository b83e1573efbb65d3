#include "renderer/app/live_scene.h"

namespace fire3dv::app {

LiveScene::LiveScene(const scene::Scene& scene, state::PoseState& poses, passes::SceneRenderer& renderer,
                     CameraRig& camera)
    : scene_(scene), poses_(poses) {
  renderer.set_edits(edits_);
  camera.set_edits(edits_);
}

bool LiveScene::follow() {
  std::vector<state::SceneChanges> changes = poses_.take_scene_changes();
  // Who moves a node decides whose edits of it count.
  if (changes.empty() && (book_.empty() || bindings_seen_ == poses_.binding_revision())) return false;
  bindings_seen_ = poses_.binding_revision();
  book_.take(std::move(changes));
  edits_.set(scene_, book_.resolve(scene_, poses_));
  return false;
}

std::vector<std::string> LiveScene::take_notes() {
  return book_.take_notes();
}

}  // namespace fire3dv::app
