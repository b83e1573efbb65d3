#include "renderer/camera/camera_rig.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "base/nearest_names.h"
#include "renderer/passes/outputs/planes_and_boxes.h"
#include "renderer/passes/view/facing.h"
#include "renderer/scene/model/bounds.h"
#include "renderer/state/motion/animation.h"

namespace fire3dv::app {
namespace {

// World-space bounds of the visible instances of a node and its descendants, in their current poses.
scene::Box visible_bounds(const scene::Scene& scene, const state::PoseState& poses, uint32_t top) {
  scene::Box box;
  for (const wire::BoxRecord3d& shown : passes::boxes_of_instances(scene, poses)) {
    uint32_t node = shown.instance - 1;  // the instance plane has 0 for the background
    while (node != scene::kNone && node != top) node = scene.nodes[node].parent;
    if (node != top) continue;
    const std::array<float, 12>& m = shown.world_from_box;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec4 at((corner & 1) - 0.5f, (corner >> 1 & 1) - 0.5f, (corner >> 2) - 0.5f, 1);
      box.add({glm::dot(glm::vec4(m[0], m[1], m[2], m[3]), at),
               glm::dot(glm::vec4(m[4], m[5], m[6], m[7]), at),
               glm::dot(glm::vec4(m[8], m[9], m[10], m[11]), at)});
    }
  }
  return box;
}

// The same field of view with square pixels and the principal point in the middle.
scene::Camera centred(scene::Camera camera) {
  camera.orthographic = false;
  camera.pixel_aspect = 1;
  camera.principal_point = {0, 0};
  return camera;
}

}  // namespace

Result<CameraRig> CameraRig::create(const scene::Scene& scene, const CameraStart& start) {
  CameraRig rig(scene);
  rig.free_camera_.name = "auto";
  rig.animations_ = start.animations;
  rig.ground_ = start.ground;
  const std::vector<uint32_t> nodes = scene::camera_nodes(scene);
  const auto find = [&](auto&& has_name) {
    const auto node = std::find_if(nodes.begin(), nodes.end(), has_name);
    return node == nodes.end() ? scene::kNone : *node;
  };
  if (start.name.empty()) {
    // A scene with a default view of its own starts with it.
    if (!nodes.empty() && scene.view_from == glm::vec3(0)) rig.node_ = nodes.front();
  } else {
    rig.node_ = find([&](uint32_t n) { return scene.nodes[n].name == start.name; });
    if (rig.node_ == scene::kNone)
      rig.node_ = find([&](uint32_t n) { return scene.cameras[scene.nodes[n].camera].name == start.name; });
    if (rig.node_ == scene::kNone && start.name != "auto") {
      std::vector<std::string> known;
      for (const uint32_t n : nodes) {
        known.push_back(scene.nodes[n].name);
        known.push_back(scene.cameras[scene.nodes[n].camera].name);
      }
      const std::string hint = name_hint(start.name, known, "named cameras");
      return Error{"--camera " + start.name + ": " + scene.source.string() +
                   (nodes.empty() ? " has no cameras; use --camera auto or leave it out"
                                  : " has no such camera" + hint + (hint.ends_with('?') ? " Or" : "; or") +
                                        " use --camera auto")};
    }
  }
  if (start.frame_all && rig.node_ != scene::kNone) {
    rig.free_camera_ = centred(rig.scene_camera());
    rig.framing_orientation_ = scene.nodes[rig.node_].world_from_node;
    rig.node_ = scene::kNone;
  }
  return rig;
}

// Nodes of the file keep their indices in all versions of the scene.
void CameraRig::set_scene(const scene::Scene& scene) {
  const scene::Scene& before = *std::exchange(scene_, &scene);
  std::erase_if(animations_, [&](uint32_t animation) { return animation >= scene.animations.size(); });
  const auto is_same = [&](uint32_t node, uint32_t node_before) {
    return node < scene.nodes.size() && scene.nodes[node].path == before.nodes[node_before].path;
  };
  if (followed_ != scene::kNone && !is_same(followed_, followed_)) followed_ = scene::kNone;
  if (node_ == scene::kNone && lost_path_.empty()) return;
  const std::vector<uint32_t> nodes = scene::camera_nodes(scene);
  if (!lost_path_.empty()) {
    const auto found = std::find_if(nodes.begin(), nodes.end(),
                                    [&](uint32_t node) { return scene.nodes[node].path == lost_path_; });
    if (found != nodes.end()) {
      node_ = *found;
      lost_path_.clear();
      return;
    }
    if (node_ == scene::kNone) return;
  }
  // Several nodes may have the path.
  if (std::find(nodes.begin(), nodes.end(), node_) != nodes.end() && is_same(node_, node_)) return;
  const auto same =
      std::find_if(nodes.begin(), nodes.end(), [&](uint32_t node) { return is_same(node, node_); });
  if (same != nodes.end()) {
    node_ = *same;
    return;
  }
  if (lost_path_.empty()) lost_path_ = before.nodes[node_].path;
  node_ = nodes.empty() ? scene::kNone : nodes.front();
}

const scene::Camera& CameraRig::scene_camera() const {
  const scene::Camera* const edited = edits_ ? edits_->camera_at(node_) : nullptr;
  return edited ? *edited : scene_->cameras[scene_->nodes[node_].camera];
}

passes::View CameraRig::view(const state::PoseState& poses, float image_aspect) const {
  const Placed now = placed(poses, image_aspect);
  passes::View view = passes::make_view(now.camera, now.world_from_camera, image_aspect);
  if (node_ != scene::kNone && !scene_->nodes[node_].name.empty()) view.camera = scene_->nodes[node_].name;
  view.ground = ground_;
  return view;
}

CameraRig::Placed CameraRig::placed(const state::PoseState& poses, float image_aspect) const {
  if (node_ != scene::kNone) return {scene_camera(), poses.world_from_node(node_)};
  if (framed_) frame_scene(image_aspect);
  scene::Camera camera = free_camera_;
  camera.near_m = std::min(0.01f, 0.01f * std::max(focus_distance_m_, 1e-3f));
  return {camera, world_from_free_};
}

// Bounds at rest and at several times of the animations, so that a moving figure stays in the image.
void CameraRig::frame_scene(float image_aspect) const {
  const std::vector<glm::mat4> world_from_node = state::rest_pose(*scene_).world_from_node;
  std::vector<glm::vec3> points = passes::framing_points(*scene_, world_from_node);
  if (!animations_.empty()) {
    float duration_s = 0;
    for (const uint32_t animation : animations_)
      duration_s = std::max(duration_s, scene_->animations[animation].duration_s);
    state::AnimationPlayer player(*scene_, animations_);
    points.clear();
    constexpr int kSamples = 24;
    for (int i = 0; i < kSamples; ++i) {
      const std::vector<glm::vec3> moved = passes::framing_points(
          *scene_, player.at(static_cast<double>(duration_s) * i / kSamples).world_from_node);
      points.insert(points.end(), moved.begin(), moved.end());
    }
  }
  if (!framed_points_.empty()) points = framed_points_;
  if (points.empty()) points.insert(points.end(), {scene_->bounds_min, scene_->bounds_max});
  glm::vec3 low = points.front(), high = low;
  for (const glm::vec3& point : points) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  scene::Camera camera = free_camera_;
  camera.near_m = std::max(1e-3f * glm::length(high - low), 1e-6f);
  const glm::mat4 orientation = framing_orientation_ == passes::default_orientation()
                                    ? passes::default_orientation(*scene_, world_from_node)
                                    : framing_orientation_;
  world_from_free_ = passes::fit_into_view(camera, image_aspect, orientation, points);
  const glm::vec3 middle = 0.5f * (low + high);
  if (ground_ && std::abs(ground_->height_m - low.y) < 0.02f * glm::length(high - low)) {
    // Not cut at the image's border: shadows on the ground below the scene, but for lights whose shadows
    // would make the scene too small, and for lights after the first ones.
    constexpr float kMaxFurther = 1.7f;
    constexpr size_t kMaxLights = 8;
    const float farthest_m = kMaxFurther * glm::distance(glm::vec3(world_from_free_[3]), middle);
    std::vector<std::vector<glm::vec3>> lights = passes::ground_shadows(*scene_, points, ground_->height_m);
    if (lights.size() > kMaxLights) lights.resize(kMaxLights);
    std::vector<glm::vec3> shown;
    for (const std::vector<glm::vec3>& shadows : lights) {
      const size_t before = shown.size();
      shown.insert(shown.end(), shadows.begin(), shadows.end());
      if (passes::shows_all(camera, image_aspect, world_from_free_, shadows)) continue;
      const glm::mat4 pose = passes::fit_into_view(camera, image_aspect, orientation, points, shown);
      if (glm::distance(glm::vec3(pose[3]), middle) < farthest_m)
        world_from_free_ = pose;
      else
        shown.resize(before);
    }
  }
  const glm::vec3 eye(world_from_free_[3]);
  focus_distance_m_ =
      std::max(glm::dot(middle - eye, -glm::vec3(world_from_free_[2])), 1e-3f * scene_radius_m());
  framed_ = false;
}

void CameraRig::let_go(const state::PoseState& poses) {
  lost_path_.clear();
  if (node_ == scene::kNone) return;
  free_camera_ = scene_camera();
  free_camera_.orthographic = false;
  free_camera_.lens.of_stream = false;  // the user's from now on
  free_camera_.name = "free";
  world_from_free_ = poses.world_from_node(node_);
  framed_ = false;
  focus_distance_m_ = focus_distance_of(world_from_free_);
  node_ = scene::kNone;
}

// Of the point on the line of sight closest to the scene's centre.
float CameraRig::focus_distance_of(const glm::mat4& world_from_camera) const {
  const glm::vec3 center = 0.5f * (scene_->bounds_min + scene_->bounds_max);
  const glm::vec3 eye(world_from_camera[3]);
  return std::max(glm::dot(center - eye, -glm::vec3(world_from_camera[2])), 0.1f * scene_radius_m());
}

glm::vec3 CameraRig::focus(const state::PoseState& poses, float image_aspect) const {
  const glm::mat4 pose = placed(poses, image_aspect).world_from_camera;
  if (node_ == scene::kNone) return focus();
  return glm::vec3(pose[3]) - focus_distance_of(pose) * glm::vec3(pose[2]);
}

glm::vec3 CameraRig::focus() const {
  return glm::vec3(world_from_free_[3]) - focus_distance_m_ * glm::vec3(world_from_free_[2]);
}

void CameraRig::orbit(const state::PoseState& poses, float yaw_rad, float pitch_rad) {
  let_go(poses);
  const glm::vec3 center = focus();
  // Not the difference of positions, which may be 0 far from the origin.
  glm::vec3 offset = focus_distance_m_ * glm::vec3(world_from_free_[2]);
  offset = glm::vec3(glm::rotate(glm::mat4(1), yaw_rad, glm::vec3(0, 1, 0)) * glm::vec4(offset, 0));
  const float pitch = std::asin(std::clamp(offset.y / glm::length(offset), -1.0f, 1.0f));
  constexpr float kLimit = 1.55f;  // excludes the poles, where the right axis is undefined
  const float allowed = std::clamp(pitch + pitch_rad, -kLimit, kLimit) - pitch;
  const glm::vec3 level = glm::cross(glm::vec3(0, 1, 0), offset);
  // At the poles the camera's own right axis is used.
  const glm::vec3 right = glm::length(level) > 1e-6f * glm::length(offset) ? glm::normalize(level)
                                                                           : glm::vec3(world_from_free_[0]);
  offset = glm::vec3(glm::rotate(glm::mat4(1), -allowed, right) * glm::vec4(offset, 0));
  world_from_free_ = passes::look_at_pose(offset, glm::vec3(0));
  world_from_free_[3] = glm::vec4(center + offset, 1);
}

void CameraRig::pan(const state::PoseState& poses, float right_fraction, float up_fraction) {
  let_go(poses);
  const glm::vec3 move = focus_distance_m_ * (right_fraction * glm::vec3(world_from_free_[0]) +
                                              up_fraction * glm::vec3(world_from_free_[1]));
  world_from_free_[3] += glm::vec4(move, 0);
}

void CameraRig::zoom(const state::PoseState& poses, float factor, const glm::vec2& at_ndc,
                     float image_aspect) {
  let_go(poses);
  const passes::View seen = view(poses, image_aspect);
  const glm::vec3 eye(world_from_free_[3]), forward = -glm::vec3(world_from_free_[2]);
  const glm::vec3 ray =
      seen.world_from_ndc_x * at_ndc.x + seen.world_from_ndc_y * at_ndc.y + seen.world_from_ndc_origin;
  const glm::vec3 fixed = eye + ray * (focus_distance_m_ / glm::dot(ray, forward));
  const float distance =
      std::clamp(focus_distance_m_ * factor, 1e-4f * scene_radius_m(), 1e3f * scene_radius_m());
  world_from_free_[3] = glm::vec4(fixed + (eye - fixed) * (distance / focus_distance_m_), 1);
  focus_distance_m_ = distance;
}

void CameraRig::fly(const state::PoseState& poses, const glm::vec3& camera_direction, float distance_m) {
  let_go(poses);
  world_from_free_[3] += world_from_free_ * glm::vec4(camera_direction * distance_m, 0);
}

void CameraRig::select(size_t scene_camera) {
  const std::vector<uint32_t> nodes = scene::camera_nodes(*scene_);
  if (scene_camera >= nodes.size()) return;
  node_ = nodes[scene_camera];
  lost_path_.clear();
}

void CameraRig::frame_all(float image_aspect) {
  lost_path_.clear();
  node_ = scene::kNone;
  free_camera_ = centred(free_camera_);
  framing_orientation_ = passes::default_orientation();
  frame_scene(image_aspect);
}

void CameraRig::frame_node(const state::PoseState& poses, uint32_t node, float image_aspect) {
  if (node >= scene_->nodes.size()) return;
  let_go(poses);
  free_camera_ = centred(free_camera_);
  (void)view(poses, image_aspect);  // places a free camera that is not placed yet
  scene::Box box = visible_bounds(*scene_, poses, node);
  const glm::vec3 origin(poses.world_from_node(node)[3]);
  // An empty node gets room in proportion to the scene. The radius of the scene does not follow edits: an
  // added file may be scaled far below its own size.
  const float least_radius = (box.empty() ? 1e-2f : 1e-5f) * scene_radius_m();
  if (box.empty()) box.add(origin);
  const glm::vec3 center = 0.5f * (box.low + box.high);
  const float radius = std::max(0.5f * glm::length(box.high - box.low), least_radius);
  const float half_fov = 0.5f * free_camera_.vertical_fov_rad;
  const float half_width = std::atan(std::tan(half_fov) * std::max(image_aspect, 1e-3f));
  constexpr float kRoom = 1.2f;
  focus_distance_m_ = kRoom * radius / std::sin(std::min(half_fov, half_width));
  world_from_free_[3] = glm::vec4(center + focus_distance_m_ * glm::vec3(world_from_free_[2]), 1);
}

std::optional<CameraRig::FreeView> CameraRig::free_view() const {
  if (node_ != scene::kNone || framed_) return std::nullopt;
  return FreeView{glm::vec3(world_from_free_[3]), glm::quat_cast(glm::mat3(world_from_free_)),
                  focus_distance_m_, free_camera_.vertical_fov_rad};
}

void CameraRig::set_free_view(const FreeView& view) {
  lost_path_.clear();
  node_ = scene::kNone;
  free_camera_ = centred(free_camera_);
  free_camera_.vertical_fov_rad = view.vertical_fov_rad;
  world_from_free_ = glm::mat4_cast(glm::normalize(view.world_from_camera));
  world_from_free_[3] = glm::vec4(view.position_m, 1);
  focus_distance_m_ = view.focus_distance_m;
  framed_ = false;
}

void CameraRig::follow(const state::PoseState& poses, uint32_t node) {
  if (node >= scene_->nodes.size()) {
    followed_ = scene::kNone;
    return;
  }
  const glm::vec3 at(poses.world_from_node(node)[3]);
  if (followed_ == node && is_free() && !framed_) world_from_free_[3] += glm::vec4(at - followed_at_, 0);
  followed_ = node;
  followed_at_ = at;
}

float CameraRig::scene_radius_m() const {
  return std::max(0.5f * glm::length(scene_->bounds_max - scene_->bounds_min), 1e-3f);
}

}  // namespace fire3dv::app
