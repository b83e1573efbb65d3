// Test of picked points and the measuring tool without a window: points keep their place on moving nodes, two
// clicks make a distance, and the markers that show it.
#include "renderer/window/measurement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "renderer/editing/view_transfer.h"
#include "renderer/scene/model/math.h"
#include "renderer/window/overlay_markers.h"
#include "renderer/window/view_control.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {
namespace {

class Measurements : public ::testing::Test {
 protected:
  // A click that hits node 1 or the background at a point of the world.
  std::optional<std::string> click(const glm::vec3& world, uint32_t node = 1) {
    passes::Picked picked;
    picked.node = node;
    picked.position_world = world;
    picked.depth_m = node == scene::kNone ? std::numeric_limits<float>::infinity() : 1;
    if (node != scene::kNone) picked.world_from_node = poses_.world_from_node(node);
    return take_pick(view_state_, picked, poses_);
  }
  void move_node(const glm::mat4& world_from_node) {
    wire::StreamDescription description;
    description.adapter_name = "simulator";
    description.epoch = 7;
    description.node_names = {"box0"};
    const state::StreamId id = poses_.add_stream(description);
    const std::vector<wire::Affine3x4> moved{scene::to_affine(world_from_node)};
    wire::PoseFrameView frame;
    frame.header.epoch = 7;
    frame.header.sequence = 1;
    frame.node_count = 1;
    frame.poses = moved;
    poses_.push(id, frame);
    ASSERT_NEAR(poses_.world_from_node(1)[3].x, world_from_node[3].x, 1e-6f);
  }
  OverlayMarkers::ImageView seen(float display_scale = 1) const {
    return {scene_, edits_, poses_, 1, scene::kNone, 1.5f, display_scale};
  }
  static void expect_near(const glm::vec3& a, const glm::vec3& b) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a[axis], b[axis], 1e-5f) << axis;
  }

  scene::Scene scene_ = boxes_at({{-3, 1, 0}, {2, -1, 1}});
  state::PoseState poses_{scene_};
  scene::SceneEdits edits_;
  ViewState view_state_;
};

TEST_F(Measurements, PickedPointMovesWithItsNode) {
  EXPECT_FALSE(click({-2.5f, 1.25f, 0.5f}));
  EXPECT_EQ(view_state_.selected, 1u);
  ASSERT_TRUE(view_state_.picked_point);
  expect_near(view_state_.picked_point->position_node, {0.5f, 0.25f, 0.5f});
  // A quarter turn about y and a move: (x, y, z) becomes (z, y, -x).
  const float right_angle = std::acos(0.0f);
  move_node(glm::rotate(glm::translate(glm::mat4(1), {10, 0, 0}), right_angle, {0, 1, 0}));
  expect_near(position_world(*view_state_.picked_point, poses_), {10.5f, 0.25f, -0.5f});
  EXPECT_FALSE(click({0, 0, 0}, scene::kNone));
  EXPECT_EQ(view_state_.selected, scene::kNone);
  EXPECT_FALSE(view_state_.picked_point);
}

TEST_F(Measurements, FocusIsAlongViewDirection) {
  CameraRig rig = *CameraRig::create(scene_);
  rig.set_free_view({.position_m = {0, 0, 10}, .focus_distance_m = 10});
  const auto focus = [&] {
    view_state_.commands.focus_on_point = true;
    move_camera(rig, {}, view_state_, poses_, {160, 120}, 0);
    EXPECT_FALSE(view_state_.commands.focus_on_point) << "once";
    EXPECT_EQ(view_state_.paths.lens, view_state_.draw.post.lens);
    return view_state_.draw.post.lens;
  };
  EXPECT_TRUE(focus().is_pinhole()) << "no point";
  click({-2.5f, 1.25f, 0.5f});
  EXPECT_FLOAT_EQ(focus().focus_distance_m, 9.5f) << "beside the axis, the same distance";
  EXPECT_FLOAT_EQ(view_state_.draw.post.lens.f_number, 2.8f);
  view_state_.draw.post.lens.f_number = 1.4f;
  move_node(glm::translate(glm::mat4(1), {0, 0, -5}));  // with the point
  EXPECT_FLOAT_EQ(focus().focus_distance_m, 14.5f);
  EXPECT_FLOAT_EQ(view_state_.draw.post.lens.f_number, 1.4f);
  rig.set_free_view({.position_m = {0, 0, -10}, .focus_distance_m = 10});
  EXPECT_FLOAT_EQ(focus().focus_distance_m, 14.5f) << "behind the camera";
}

TEST_F(Measurements, SingularNodeRestsInWorld) {
  passes::Picked picked;
  picked.node = 1;
  picked.position_world = {1, 2, 3};
  picked.world_from_node = glm::scale(glm::mat4(1), {1, 0, 1});
  const SurfacePoint point = surface_point(picked);
  EXPECT_EQ(point.node, scene::kNone);
  EXPECT_EQ(position_world(point, poses_), glm::vec3(1, 2, 3));
}

TEST_F(Measurements, SkinnedSurfaceRestsInWorld) {
  passes::Picked picked;
  picked.node = 1;
  picked.position_world = {1, 2, 3};
  picked.world_from_node.reset();
  EXPECT_FALSE(take_pick(view_state_, picked, poses_));
  EXPECT_EQ(view_state_.selected, 1u);
  ASSERT_TRUE(view_state_.picked_point);
  EXPECT_EQ(*view_state_.picked_point, (SurfacePoint{scene::kNone, {1, 2, 3}}));
}

// Numbers come from a device.
TEST_F(Measurements, UnknownNodeIsBackground) {
  passes::Picked picked;
  picked.node = static_cast<uint32_t>(scene_.nodes.size());
  picked.position_world = {1, 2, 3};
  EXPECT_FALSE(take_pick(view_state_, picked, poses_));
  EXPECT_EQ(view_state_.selected, scene::kNone);
  EXPECT_FALSE(view_state_.picked_point);
  EXPECT_EQ(position_world({picked.node, {1, 2, 3}}, poses_), glm::vec3(1, 2, 3));
}

// An added file may be scaled far below its own size, which bounds the scene.
TEST_F(Measurements, SmallNodeFillsView) {
  scene_.bounds_min = glm::vec3(-1000);
  scene_.bounds_max = glm::vec3(1000);
  CameraRig rig = *CameraRig::create(scene_);
  rig.frame_node(poses_, 1, 1);
  const glm::vec3 eye(rig.placed(poses_, 1).world_from_camera[3]);
  EXPECT_LT(glm::length(eye - glm::vec3(poses_.world_from_node(1)[3])), 10);
}

TEST_F(Measurements, TwoClicksMeasureDistance) {
  view_state_.measures = true;
  view_state_.selected = 2;
  EXPECT_FALSE(click({-3, 1, 0.5f}));
  EXPECT_FALSE(click({0, 0, 0}, scene::kNone));  // the background is no point
  ASSERT_EQ(view_state_.measured.size(), 1u);
  const auto message = click({0, 5, 0.5f});
  ASSERT_TRUE(message);
  EXPECT_EQ(*message, "distance 5 m from -3 1 0.5 to 0 5 0.5; along x y z: 3 4 0");
  EXPECT_EQ(view_state_.selected, 2u) << "measuring selects nothing";
  EXPECT_FALSE(click({7, 0, 0}));
  EXPECT_EQ(view_state_.measured.size(), 1u);
}

TEST_F(Measurements, MarkersKeepIds) {
  OverlayMarkers overlay;
  EXPECT_TRUE(overlay.update(view_state_, seen()).empty());
  view_state_.measures = true;
  EXPECT_TRUE(overlay.update(view_state_, seen()).empty());
  click({-3, 1, 0});
  ASSERT_EQ(overlay.update(view_state_, seen()).size(), 1u);
  click({0, 5, 0});
  const std::vector<state::ShownMarker> first = overlay.update(view_state_, seen());
  ASSERT_EQ(first.size(), 4u);
  std::set<uint64_t> ids;
  bool has_text = false;
  for (const state::ShownMarker& shown : first) {
    ids.insert(shown.id);
    EXPECT_TRUE((shown.marker->flags & wire::kMarkerOverlaid) != 0);
    if (shown.marker->kind == wire::MarkerKind::texts) {
      EXPECT_EQ(shown.marker->texts, std::vector<std::string>{"5 m\n"});
      has_text = true;
    }
  }
  EXPECT_TRUE(has_text);
  EXPECT_EQ(ids.size(), 4u);
  const std::vector<state::ShownMarker> again = overlay.update(view_state_, seen());
  for (size_t i = 0; i < 4; ++i)
    EXPECT_EQ(again[i].id, first[i].id) << "an equal marker is not uploaded again";
  move_node(glm::translate(glm::mat4(1), {-3, 1, 2}));  // both points are on it
  const std::vector<state::ShownMarker> moved = overlay.update(view_state_, seen());
  ASSERT_EQ(moved.size(), 4u);
  for (const state::ShownMarker& shown : moved) {
    EXPECT_FALSE(ids.contains(shown.id)) << "other positions need another id";
    for (const auto& position : shown.marker->positions) EXPECT_NEAR(position[2], 2, 1e-5f);
  }
  const std::vector<state::ShownMarker> large = overlay.update(view_state_, seen(2));
  for (size_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(large[i].marker->width, 2 * moved[i].marker->width);
}

TEST_F(Measurements, SceneChangeKeepsPoints) {
  view_state_.measures = true;
  click({-3, 1, 0});
  click({2, -1, 1}, 2);
  view_state_.picked_point = SurfacePoint{2, {0, 0, 0}};
  scene::Scene after = boxes_at({{2, -1, 1}});  // without "box1"
  const state::NodeNames names(scene_), names_after(after);
  transfer_by_key(view_state_, {scene_, names}, {after, names_after});
  ASSERT_EQ(view_state_.measured.size(), 1u);
  EXPECT_EQ(view_state_.measured[0].node, 1u);
  EXPECT_FALSE(view_state_.picked_point);
  forget_scene(view_state_);
  EXPECT_TRUE(view_state_.measured.empty());
}

}  // namespace
}  // namespace fire3dv::app
