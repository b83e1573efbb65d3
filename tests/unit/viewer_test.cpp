// What the user of a window does, without a window: keys and mouse as wishes, the camera's moves, what is
// left of wishes when another scene is shown.
#include <gtest/gtest.h>

#include "renderer/app/show.h"
#include "renderer/app/viewer_control.h"

namespace fire3dv::app {
namespace {

using sinks::Button;
using sinks::InputEvent;
using sinks::Key;
using Kind = InputEvent::Kind;

constexpr float kAspect = 1.5f;
constexpr glm::uvec2 kImage{900, 600};

// A box of 2 m at each of the places, as "box0", "box1", ... below "top"; a camera at 10 m in front of all.
scene::Scene boxes_at(const std::vector<glm::vec3>& places) {
  scene::Scene scene;
  scene.materials.emplace_back();
  scene::Primitive cube;
  cube.index_count = 36;
  cube.bounds_min = glm::vec3(-1);
  cube.bounds_max = glm::vec3(1);
  scene.primitives.push_back(cube);
  scene.meshes.push_back({"cube", 0, 1, 0});
  scene.cameras.emplace_back();
  scene::Node top;
  top.name = top.path = "top";
  scene.nodes.push_back(top);
  for (size_t i = 0; i < places.size(); ++i) {
    scene::Node box;
    box.name = "box" + std::to_string(i);
    box.path = "top/" + box.name;
    box.parent = 0;
    box.translation = places[i];
    box.mesh = 0;
    scene.nodes.push_back(box);
  }
  scene::Node eye;
  eye.name = eye.path = "eye";
  eye.translation = {0, 0, 10};
  eye.camera = 0;
  scene.nodes.push_back(eye);
  for (scene::Node& node : scene.nodes) {
    node.parent_from_node = scene::parent_from_parts(node.translation, node.rotation, node.scale);
    node.world_from_node = node.parent == scene::kNone
                               ? node.parent_from_node
                               : scene.nodes[node.parent].world_from_node * node.parent_from_node;
  }
  scene.bounds_min = glm::vec3(-5);
  scene.bounds_max = glm::vec3(5);
  return scene;
}

glm::vec2 ndc_of(const passes::View& view, const glm::vec3& world) {
  const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
  return glm::vec2(clip) / clip.w;
}

class Cameras : public ::testing::Test {
 protected:
  scene::Scene scene_ = boxes_at({{-3, 1, 0}, {2, -1, 1}});
  state::PoseState poses_{scene_};
  CameraRig rig_ = *CameraRig::create(scene_, "");

  void expect_at(const glm::vec3& world, const glm::vec2& ndc) {
    const glm::vec2 seen = ndc_of(rig_.view(poses_, kAspect), world);
    EXPECT_NEAR(seen.x, ndc.x, 1e-4f);
    EXPECT_NEAR(seen.y, ndc.y, 1e-4f);
  }
};

TEST_F(Cameras, ZoomKeepsWhatIsBelowTheCursor) {
  // At the focus' depth, which is the middle of the scene.
  const glm::vec3 below(2.5f, -1.25f, 0);
  const glm::vec2 cursor = ndc_of(rig_.view(poses_, kAspect), below);
  ASSERT_GT(std::abs(cursor.x), 0.1f);
  for (const float factor : {0.85f, 0.5f, 1.7f}) {
    const glm::vec3 before = rig_.view(poses_, kAspect).eye_world;
    rig_.zoom(poses_, factor, cursor, kAspect);
    expect_at(below, cursor);
    const glm::vec3 after = rig_.view(poses_, kAspect).eye_world;
    EXPECT_NEAR(glm::length(after - below), factor * glm::length(before - below), 1e-3f);
  }
}

TEST_F(Cameras, ZoomEndsBeforeTheFocus) {
  for (int i = 0; i < 1000; ++i) rig_.zoom(poses_, 0.5f, {0.3f, 0.2f}, kAspect);
  const passes::View near = rig_.view(poses_, kAspect);
  EXPECT_GT(near.near_m, 0);
  EXPECT_TRUE(std::isfinite(near.clip_from_world[0][0]));
  for (int i = 0; i < 1000; ++i) rig_.zoom(poses_, 2, {0.3f, 0.2f}, kAspect);
  EXPECT_LT(glm::length(rig_.view(poses_, kAspect).eye_world), 2e3f * rig_.scene_radius_m());
}

TEST_F(Cameras, ANodeIsFramedWholeInTheMiddleFromWhereTheCameraLooks) {
  const glm::vec3 look = rig_.view(poses_, kAspect).look_world;
  for (const float aspect : {kAspect, 0.4f}) {
    rig_.frame_node(poses_, 2, aspect);
    const passes::View view = rig_.view(poses_, aspect);
    EXPECT_NEAR(glm::dot(view.look_world, look), 1, 1e-5f);
    const glm::vec2 middle = ndc_of(view, {2, -1, 1});
    EXPECT_NEAR(middle.x, 0, 1e-4f);
    EXPECT_NEAR(middle.y, 0, 1e-4f);
    float farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 at =
          glm::vec3(2, -1, 1) + glm::vec3(corner & 1, corner >> 1 & 1, corner >> 2) * 2.0f - 1.0f;
      const glm::vec2 ndc = glm::abs(ndc_of(view, at));
      farthest = std::max({farthest, ndc.x, ndc.y});
    }
    EXPECT_LT(farthest, 1);
    EXPECT_GT(farthest, 0.4f);  // and large
  }
}

TEST_F(Cameras, WhatIsAboveIsFramedWithAllBelowIt) {
  rig_.frame_node(poses_, 0, kAspect);
  const passes::View view = rig_.view(poses_, kAspect);
  for (const glm::vec3 at : {glm::vec3(-4, 2, -1), glm::vec3(3, -2, 2)}) {
    const glm::vec2 ndc = glm::abs(ndc_of(view, at));
    EXPECT_LT(std::max(ndc.x, ndc.y), 1);
  }
}

TEST_F(Cameras, AFreeCameraGoesWithTheNodeItFollows) {
  rig_.let_go(poses_);
  rig_.follow(poses_, 1);
  const glm::vec3 before = rig_.view(poses_, kAspect).eye_world;
  scene::Scene moved = scene_;  // what is above moves it, too
  for (scene::Node& node : moved.nodes) node.world_from_node[3] += glm::vec4(1, 2, 3, 0);
  moved.nodes[0].parent_from_node[3] += glm::vec4(1, 2, 3, 0);
  poses_.set_rest(state::rest_pose(moved));
  rig_.follow(poses_, 1);
  rig_.follow(poses_, 1);
  const glm::vec3 step = rig_.view(poses_, kAspect).eye_world - before;
  EXPECT_NEAR(glm::length(step - glm::vec3(1, 2, 3)), 0, 1e-5f);
  rig_.follow(poses_, 2);  // another one: from where it is now
  EXPECT_EQ(rig_.view(poses_, kAspect).eye_world, before + step);
}

TEST_F(Cameras, ASceneCameraStaysWhereItIsWhileANodeIsFollowed) {
  const glm::vec3 before = rig_.view(poses_, kAspect).eye_world;
  rig_.follow(poses_, 1);
  rig_.follow(poses_, 1);
  EXPECT_FALSE(rig_.is_free());
  EXPECT_EQ(rig_.view(poses_, kAspect).eye_world, before);
}

TEST_F(Cameras, FlyingFollowsTheScenesSizeAndTheUsersSpeed) {
  const auto flown = [&](float speed) {
    gui::Viewer viewer;
    viewer.camera_speed = speed;
    CameraRig rig = *CameraRig::create(scene_, "");
    CameraMoves moves;
    moves.fly = {0, 0, -1};
    const glm::vec3 before = rig.view(poses_, kAspect).eye_world;
    move_camera(rig, moves, viewer, poses_, kImage, 0.05f);
    return glm::length(rig.view(poses_, kAspect).eye_world - before);
  };
  const float once = flown(1);
  EXPECT_GT(once, 0);
  EXPECT_NEAR(flown(4), 4 * once, 1e-4f);
  scene_.bounds_min *= 10;
  scene_.bounds_max *= 10;
  EXPECT_NEAR(flown(1), 10 * once, 1e-3f);
}

TEST_F(Cameras, CommandsAreDoneOnce) {
  gui::Viewer viewer;
  viewer.selected = 2;
  viewer.commands.frame_selection = true;
  move_camera(rig_, {}, viewer, poses_, kImage, 0);
  EXPECT_TRUE(rig_.is_free());
  EXPECT_FALSE(viewer.commands.frame_selection);
  viewer.commands.camera = 0;
  move_camera(rig_, {}, viewer, poses_, kImage, 0);
  EXPECT_FALSE(rig_.is_free());
  EXPECT_FALSE(viewer.commands.camera);
  viewer.commands.camera = 7;  // there is none
  move_camera(rig_, {}, viewer, poses_, kImage, 0);
  EXPECT_FALSE(rig_.is_free());
}

// A hand on mouse and keyboard.
class Inputs : public ::testing::Test {
 protected:
  void add(InputEvent event) {
    event.cursor_px = cursor_;
    event.modifiers = modifiers_;
    pending_.events.push_back(event);
  }
  void move(float x, float y) {
    cursor_ = {x, y};
    add({});
  }
  void press(Button button, bool down) { add({.kind = Kind::button, .button = button, .down = down}); }
  void key(Key key, bool down = true) { add({.kind = Kind::key, .key = key, .down = down}); }
  void type(Key k) {
    key(k);
    key(k, false);
  }
  CameraMoves take(ViewerInput::Owners owners = {}) {
    return input_.take(std::exchange(pending_, {}), owners, viewer_);
  }

  gui::Viewer viewer_;
  ViewerInput input_;
  sinks::WindowInput pending_;
  sinks::Modifiers modifiers_;
  glm::vec2 cursor_{0};
};

TEST_F(Inputs, AClickIsNoDragAndADragNoClick) {
  move(100, 50);
  press(Button::left, true);
  move(102, 51);  // a hand trembles
  press(Button::left, false);
  CameraMoves moves = take();
  ASSERT_TRUE(moves.click_px);
  EXPECT_EQ(*moves.click_px, glm::vec2(102, 51));
  EXPECT_EQ(moves.orbit_px, glm::vec2(0));

  press(Button::left, true);
  move(112, 51);
  take();
  move(112, 71);
  press(Button::left, false);
  moves = take();
  EXPECT_FALSE(moves.click_px);
  EXPECT_EQ(moves.orbit_px, glm::vec2(0, 20));
}

TEST_F(Inputs, TheRightButtonAndShiftPan) {
  press(Button::right, true);
  move(10, 0);
  press(Button::right, false);
  EXPECT_EQ(take().pan_px, glm::vec2(10, 0));
  modifiers_.shift = true;
  press(Button::left, true);
  move(10, 20);
  press(Button::left, false);
  const CameraMoves moves = take();
  EXPECT_EQ(moves.pan_px, glm::vec2(0, 20));
  EXPECT_FALSE(moves.click_px);
}

TEST_F(Inputs, WhatPanelsWantDoesNotMoveTheView) {
  press(Button::left, true);
  move(50, 50);
  add({.kind = Kind::wheel, .wheel = {0, 2}});
  key(sinks::letter('w'));
  type(sinks::letter('h'));
  viewer_.selected = 3;
  const CameraMoves moves = take({false, false});
  EXPECT_EQ(moves.orbit_px, glm::vec2(0));
  EXPECT_EQ(moves.zoom_notches, 0);
  EXPECT_EQ(moves.fly, glm::vec3(0));
  EXPECT_TRUE(viewer_.hidden.empty());
  press(Button::left, false);
  EXPECT_FALSE(take().click_px);  // it began on a panel
}

TEST_F(Inputs, AKeyThatIsHeldEndsWithItsReleaseWhoeverHasTheKeyboardThen) {
  key(sinks::letter('w'));
  EXPECT_EQ(take().fly, glm::vec3(0, 0, -1));
  EXPECT_EQ(take().fly, glm::vec3(0, 0, -1));
  key(sinks::letter('w'), false);
  EXPECT_EQ(take({true, false}).fly, glm::vec3(0));
  key(sinks::letter('d'));
  add({.kind = Kind::focus, .down = false});
  EXPECT_EQ(take().fly, glm::vec3(0));
}

TEST_F(Inputs, EscapeTakesWhatIsInTheWayFirst) {
  viewer_.help = true;
  viewer_.selected = 1;
  type(Key::escape);
  take();
  EXPECT_FALSE(viewer_.help);
  EXPECT_EQ(viewer_.selected, 1u);
  type(Key::escape);
  take();
  EXPECT_EQ(viewer_.selected, scene::kNone);
  EXPECT_FALSE(viewer_.commands.close);
  type(Key::escape);
  take();
  EXPECT_TRUE(viewer_.commands.close);
}

TEST_F(Inputs, KeysHideIsolateFollowAndShowAgain) {
  for (const char c : {'h', 'i', 't'}) type(sinks::letter(c));
  take();
  EXPECT_TRUE(viewer_.hidden.empty());  // nothing is selected
  viewer_.selected = 5;
  for (const char c : {'h', 'i', 't'}) type(sinks::letter(c));
  take();
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{5});
  EXPECT_EQ(viewer_.isolated, 5u);
  EXPECT_EQ(viewer_.followed, 5u);
  type(sinks::letter('h'));
  type(sinks::letter('t'));
  take();
  EXPECT_TRUE(viewer_.hidden.empty());
  EXPECT_EQ(viewer_.followed, scene::kNone);
  modifiers_.shift = true;
  type(sinks::letter('h'));
  take();
  EXPECT_EQ(viewer_.isolated, scene::kNone);
}

TEST_F(Inputs, TheWheelZoomsAndWithControlSetsTheSpeed) {
  add({.kind = Kind::wheel, .wheel = {0, 2}});
  EXPECT_EQ(take().zoom_notches, 2);
  modifiers_.control = true;
  add({.kind = Kind::wheel, .wheel = {0, 1}});
  EXPECT_EQ(take().zoom_notches, 0);
  EXPECT_GT(viewer_.camera_speed, 1);
  for (int i = 0; i < 100; ++i) add({.kind = Kind::wheel, .wheel = {0, -10}});
  take();
  EXPECT_GT(viewer_.camera_speed, 0.01f);
}

TEST(Viewers, KeepWhatHasTheSamePathInAnotherScene) {
  const scene::Scene before = boxes_at({{0, 0, 0}, {1, 0, 0}});
  scene::Scene after = boxes_at({{0, 0, 0}});
  after.nodes[0].path = "other";           // in the place of "top"
  after.nodes.push_back(before.nodes[2]);  // "top/box1" is the last now
  gui::Viewer viewer;
  viewer.selected = 2;
  viewer.isolated = 0;
  viewer.followed = 99;
  viewer.hidden = {0, 1, 2};
  viewer.lights[2] = {};
  viewer.materials[0] = {};
  viewer.materials[7] = {};
  keep_by_path(viewer, before, after);
  EXPECT_EQ(viewer.selected, 3u);
  EXPECT_EQ(viewer.isolated, scene::kNone);
  EXPECT_EQ(viewer.followed, scene::kNone);
  EXPECT_EQ(viewer.hidden, (std::set<uint32_t>{1, 3}));
  EXPECT_TRUE(viewer.lights.contains(3));
  EXPECT_EQ(viewer.materials.size(), 1u);
}

TEST(Viewers, IsolatingHidesAllElseAndTakingItBackNothing) {
  const scene::Scene scene = boxes_at({{0, 0, 0}, {1, 0, 0}});
  scene::SceneEdits edits;
  scene::NodeEdits of_streams;
  of_streams[2].hidden = true;
  edits.set(scene, of_streams, 1);
  EXPECT_TRUE(edits.is_hidden(0));
  EXPECT_FALSE(edits.is_hidden(1));
  EXPECT_TRUE(edits.is_hidden(2));
  edits.set(scene, of_streams, 0);
  EXPECT_FALSE(edits.is_hidden(1));
  EXPECT_TRUE(edits.is_hidden(2));  // a stream hides it still
  EXPECT_FALSE(edits.is_removed(2));
  edits.set(scene, {});
  EXPECT_TRUE(edits.hidden().empty());
}

TEST(Viewers, ADroppedFileTakesThePlaceOfItsKind) {
  Options options;
  options.scene = "arm.glb";
  options.recording.replay = "run.mcap";
  options.recording.start_s = 5;
  options.listen = {"shm://demo"};
  Options other = with_file(options, "other.gltf");
  EXPECT_EQ(other.scene, "other.gltf");
  EXPECT_EQ(other.recording.replay, "");
  EXPECT_EQ(other.listen, options.listen);
  other = with_file(options, "later.mcap");
  EXPECT_EQ(other.recording.replay, "later.mcap");
  EXPECT_EQ(other.recording.start_s, 0);
  EXPECT_TRUE(other.scene.empty());
}

// A stream whose way of being shown is changed while it runs: no frame is lost or shown half.
TEST(Viewers, AStreamIsShownInAnotherWayFromNowOn) {
  const scene::Scene scene = boxes_at({{0, 0, 0}, {1, 0, 0}});
  state::PoseState poses(scene);
  wire::StreamDescription description;
  description.adapter_name = "arm";
  description.epoch = 7;
  description.node_names = {"box0", "box1"};
  const state::StreamId id = poses.add_stream(description);
  constexpr int64_t kMs = 1'000'000;
  const auto push = [&](uint64_t sequence, std::vector<float> x, std::vector<uint32_t> nodes = {}) {
    std::vector<wire::Affine3x4> frame(x.size());
    for (size_t i = 0; i < x.size(); ++i) frame[i].m[3] = x[i];
    wire::PoseFrameView view;
    view.header.epoch = 7;
    view.header.sequence = sequence;
    const auto at = static_cast<int64_t>(sequence) * 10 * kMs;
    view.header.sim_time_ns = at;
    view.node_count = 2;
    view.poses = frame;
    view.node_indices = nodes;
    return poses.push(id, view, at, at);
  };
  const auto x = [&](uint32_t node) { return poses.world_from_node(node)[3].x; };
  EXPECT_TRUE(push(1, {1, 10}));
  EXPECT_EQ(x(1), 1);

  poses.interpolate(id, 20 * kMs);
  EXPECT_FALSE(push(2, {2}, {0}));  // a partial frame right after
  EXPECT_EQ(x(1), 1);               // its time has not come
  poses.advance(40 * kMs);
  EXPECT_EQ(x(1), 2);
  EXPECT_EQ(x(2), 10);

  push(3, {3, 30});
  poses.interpolate(id, 500 * kMs);  // another delay
  push(4, {4}, {0});
  poses.show_newest(id, 45 * kMs);  // what was still to come is shown at once
  EXPECT_EQ(x(1), 4);
  EXPECT_EQ(x(2), 30);
  EXPECT_TRUE(push(5, {5}, {0}));
  EXPECT_EQ(x(1), 5);
  EXPECT_EQ(x(2), 30);
}

}  // namespace
}  // namespace fire3dv::app
