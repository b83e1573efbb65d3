// Camera of a view: a camera of the scene, which a stream may drive, or a free camera controlled by the user.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "renderer/passes/view/framing.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/model/scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/pose_state.h"

namespace fire3dv::app {

// How a view begins.
struct CameraStart {
  std::string name;  // of a node or camera; "auto": a free camera that frames the scene; empty: the scene's
                     // first camera, or auto
  bool frame_all = false;  // keeps direction and lens of the named camera, but shows the whole scene
  std::vector<uint32_t> animations;     // framed over their whole time
  std::optional<scene::Ground> ground;  // of all views
};

class CameraRig {
 public:
  // The error lists the available cameras.
  static Result<CameraRig> create(const scene::Scene& scene, const CameraStart& start = {});

  // Edits of the scene's cameras; must outlive this object.
  void set_edits(const scene::SceneEdits& edits) { edits_ = &edits; }

  // Switches to another scene while the previous one is alive; keeps the view if its camera still exists, by
  // path. A camera that the scene lacks is shown again by the next scene that has it, unless the user has
  // chosen another view meanwhile.
  void set_scene(const scene::Scene& scene);

  // A free camera that is not placed yet frames these points of the world, in place of the scene at rest.
  void set_framed_points(std::vector<glm::vec3> points) { framed_points_ = std::move(points); }

  void set_ground(const std::optional<scene::Ground>& ground) { ground_ = ground; }

  passes::View view(const state::PoseState& poses, float image_aspect) const;
  // The camera of view(), and its pose.
  struct Placed {
    scene::Camera camera;
    glm::mat4 world_from_camera;
  };
  Placed placed(const state::PoseState& poses, float image_aspect) const;
  const std::optional<scene::Ground>& ground() const { return ground_; }

  // Point that the view turns about.
  glm::vec3 focus(const state::PoseState& poses, float image_aspect) const;

  // Free camera controls of the window. The first one switches from the scene's camera to a free camera at
  // its pose.
  void orbit(const state::PoseState& poses, float yaw_rad, float pitch_rad);
  void pan(const state::PoseState& poses, float right_fraction,
           float up_fraction);  // fraction of the focus distance
  // at_ndc: fixed point of the zoom at focus depth, in Vulkan NDC (-1 to 1, y down).
  void zoom(const state::PoseState& poses, float factor, const glm::vec2& at_ndc, float image_aspect);
  void fly(const state::PoseState& poses, const glm::vec3& camera_direction, float distance_m);
  void select(size_t scene_camera);            // by order; no effect if out of range
  void let_go(const state::PoseState& poses);  // switches to the free camera
  void frame_all(float image_aspect);
  // Points at the centre of the visible instances of this node and its descendants, without changing the
  // direction. Without visible instances, points at the node.
  void frame_node(const state::PoseState& poses, uint32_t node, float image_aspect);
  // Moves a free camera with the node since the last call. Must be called once per frame. kNone: no node.
  void follow(const state::PoseState& poses, uint32_t node);
  // Pose and lens of a free camera, to return to it later.
  struct FreeView {
    glm::vec3 position_m{0};
    glm::quat world_from_camera{1, 0, 0, 0};
    float focus_distance_m = 1, vertical_fov_rad = 1;
    bool operator==(const FreeView&) const = default;
  };
  // nullopt: a camera of the scene, or a free one that no image has placed yet.
  std::optional<FreeView> free_view() const;
  void set_free_view(const FreeView& view);
  bool is_free() const { return node_ == scene::kNone; }
  uint32_t node() const { return node_; }  // node of the scene's camera; kNone: free
  float scene_radius_m() const;

 private:
  explicit CameraRig(const scene::Scene& scene) : scene_(&scene) {}
  glm::vec3 focus() const;
  void frame_scene(float image_aspect) const;
  float focus_distance_of(const glm::mat4& world_from_camera) const;
  const scene::Camera& scene_camera() const;  // of node_

  const scene::Scene* scene_;
  const scene::SceneEdits* edits_ = nullptr;
  uint32_t node_ = scene::kNone;  // kNone: free
  std::string lost_path_;         // of the camera that node_ stands in for; empty: none
  scene::Camera free_camera_;
  glm::mat4 framing_orientation_ = passes::default_orientation();
  std::vector<uint32_t> animations_;
  std::vector<glm::vec3> framed_points_;  // empty: none
  std::optional<scene::Ground> ground_;
  mutable bool framed_ = true;  // free camera not framed yet for the image's aspect ratio
  mutable glm::mat4 world_from_free_{1};
  mutable float focus_distance_m_ = 1;
  uint32_t followed_ = scene::kNone;
  glm::vec3 followed_at_{0};
};

}  // namespace fire3dv::app
