// Where the view is taken from: a camera of the scene, which may be driven by a stream, or a free one that
// the user moves.
#pragma once

#include <string>
#include <vector>

#include "protocol/error.h"
#include "renderer/passes/view.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

class CameraRig {
 public:
  // name: as on the command line; empty takes the scene's first camera, or a free one that frames the scene.
  // The error lists the cameras that there are.
  static Result<CameraRig> create(const scene::Scene& scene, const std::string& name);

  // What is changed of the scene's cameras; it outlives this.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }

  // Another scene is shown: the view stays where it is, if it still has a camera there.
  void set_scene(const scene::Scene& scene);

  passes::View view(const state::PoseState& poses, float image_aspect) const;

  // Free movement, for the window. The first one leaves the scene's camera where it is and goes on from
  // there.
  void orbit(const state::PoseState& poses, float yaw_rad, float pitch_rad);
  void pan(const state::PoseState& poses, float right_fraction,
           float up_fraction);  // of the distance to the focus
  // at_ndc: the point of the image (Vulkan's: -1 to 1, y down) that stays where it is, at the focus' depth.
  void zoom(const state::PoseState& poses, float factor, const glm::vec2& at_ndc, float image_aspect);
  void fly(const state::PoseState& poses, const glm::vec3& camera_direction, float distance_m);
  void select(size_t scene_camera);            // by order; out of range: nothing
  void let_go(const state::PoseState& poses);  // free from here on
  void frame_all(float image_aspect);
  // Looks at the middle of what is shown of this node and those below it, from the side where it is; where
  // nothing is, at the node.
  void frame_node(const state::PoseState& poses, uint32_t node, float image_aspect);
  // Once a frame: a free camera moves as the node has moved since the last call. kNone: none is followed.
  void follow(const state::PoseState& poses, uint32_t node);
  bool is_free() const { return node_ == scene::kNone; }
  uint32_t node() const { return node_; }  // of the scene's camera; kNone: free
  float scene_radius_m() const;

 private:
  explicit CameraRig(const scene::Scene& scene) : scene_(&scene) {}
  glm::vec3 focus() const;
  const scene::Camera& scene_camera() const;  // of the node

  const scene::Scene* scene_;
  const scene::SceneEdits* edits_ = nullptr;
  uint32_t node_ = scene::kNone;  // kNone: free
  scene::Camera free_camera_;
  mutable bool framed_ = true;  // free and still to be framed for the image's aspect
  mutable glm::mat4 world_from_free_{1};
  mutable float focus_distance_m_ = 1;
  uint32_t followed_ = scene::kNone;
  glm::vec3 followed_at_{0};
};

}  // namespace fire3dv::app
