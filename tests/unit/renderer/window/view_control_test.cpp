// Test of viewer input and cameras without a window: keys and mouse events as user requests, camera motion,
// picking.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "renderer/window/view_control.h"
#include "renderer/window/window_panels.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {
namespace {

using sinks::Button;
using sinks::InputEvent;
using sinks::Key;
using Kind = InputEvent::Kind;

constexpr float kAspect = 1.5f;
constexpr glm::uvec2 kImage{900, 600};

glm::vec2 ndc_of(const passes::View& view, const glm::vec3& world) {
  const glm::vec4 clip = view.clip_from_world * glm::vec4(world, 1);
  return glm::vec2(clip) / clip.w;
}

class Cameras : public ::testing::Test {
 protected:
  scene::Scene scene_ = boxes_at({{-3, 1, 0}, {2, -1, 1}});
  state::PoseState poses_{scene_};
  CameraRig rig_ = *CameraRig::create(scene_);

  void expect_at(const glm::vec3& world, const glm::vec2& ndc) {
    const glm::vec2 seen = ndc_of(rig_.view(poses_, kAspect), world);
    EXPECT_NEAR(seen.x, ndc.x, 1e-4f);
    EXPECT_NEAR(seen.y, ndc.y, 1e-4f);
  }
};

TEST_F(Cameras, ZoomKeepsPointBelowCursor) {
  // At the depth of the focus, the centre of the scene.
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

// The eye is nearer to its focus than the next float.
TEST_F(Cameras, OrbitWorksFarAndClose) {
  rig_.set_free_view({{1000, 1000, 1000}, glm::quat(1, 0, 0, 0), 1e-6f, 0.8f});
  rig_.orbit(poses_, 0.5f, 0);
  const passes::View view = rig_.view(poses_, kAspect);
  EXPECT_NEAR(view.look_world.x, -std::sin(0.5f), 1e-5f);
  EXPECT_NEAR(view.look_world.z, -std::cos(0.5f), 1e-5f);
  EXPECT_EQ(view.eye_world, glm::vec3(1000));
}

// As in a reload of the file: the scene is first shown without the nodes that the user has added.
TEST_F(Cameras, LostCameraReturns) {
  const auto with_cameras = [&](const std::vector<std::string>& paths) {
    scene::Scene scene = scene_;
    for (scene::Node& node : scene.nodes) node.camera = scene::kNone;
    scene.cameras.clear();
    for (const std::string& path : paths) {
      scene::Node node;
      node.name = node.path = path;
      node.camera = static_cast<uint32_t>(scene.cameras.size());
      scene.cameras.emplace_back();
      scene.nodes.push_back(std::move(node));
    }
    return scene;
  };
  const scene::Scene both = with_cameras({"own", "added"}), bare = with_cameras({"own"}),
                     none = with_cameras({});
  const scene::Scene moved = with_cameras({"own", "other", "added"});
  const auto first = static_cast<uint32_t>(scene_.nodes.size());
  const auto shows_added = [&](const scene::Scene& meanwhile, auto&& choose) {
    CameraRig rig = *CameraRig::create(both, {"added", false, {}, {}});
    EXPECT_EQ(rig.node(), first + 1);
    rig.set_scene(meanwhile);
    choose(rig);
    rig.set_scene(moved);
    return rig.node() == first + 2;
  };
  EXPECT_TRUE(shows_added(bare, [&](CameraRig& rig) { EXPECT_EQ(rig.node(), first); }));
  EXPECT_TRUE(shows_added(none, [](CameraRig& rig) { EXPECT_TRUE(rig.is_free()); }));
  EXPECT_FALSE(shows_added(bare, [](CameraRig& rig) { rig.select(0); }));
  EXPECT_FALSE(shows_added(none, [](CameraRig& rig) {
    rig.set_free_view({{0, 0, 5}, {1, 0, 0, 0}, 5, 0.8f});
  }));
}

TEST_F(Cameras, ZoomEndsBeforeTheFocus) {
  for (int i = 0; i < 1000; ++i) rig_.zoom(poses_, 0.5f, {0.3f, 0.2f}, kAspect);
  const passes::View near = rig_.view(poses_, kAspect);
  EXPECT_GT(near.near_m, 0);
  EXPECT_TRUE(std::isfinite(near.clip_from_world[0][0]));
  for (int i = 0; i < 1000; ++i) rig_.zoom(poses_, 2, {0.3f, 0.2f}, kAspect);
  EXPECT_LT(glm::length(rig_.view(poses_, kAspect).eye_world), 2e3f * rig_.scene_radius_m());
}

TEST_F(Cameras, FramedNodeIsCentred) {
  const glm::vec3 look = rig_.view(poses_, kAspect).look_world;
  for (const float aspect : {kAspect, 0.4f}) {
    rig_.frame_node(poses_, 2, aspect);
    const passes::View view = rig_.view(poses_, aspect);
    EXPECT_NEAR(glm::dot(view.look_world, look), 1, 1e-5f);
    const glm::vec2 center = ndc_of(view, {2, -1, 1});
    EXPECT_NEAR(center.x, 0, 1e-4f);
    EXPECT_NEAR(center.y, 0, 1e-4f);
    float max_distance = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 at =
          glm::vec3(2, -1, 1) + glm::vec3(corner & 1, corner >> 1 & 1, corner >> 2) * 2.0f - 1.0f;
      const glm::vec2 ndc = glm::abs(ndc_of(view, at));
      max_distance = std::max({max_distance, ndc.x, ndc.y});
    }
    EXPECT_LT(max_distance, 1);
    EXPECT_GT(max_distance, 0.4f);  // and large
  }
}

TEST_F(Cameras, ParentsAreFramedWithTheirChildren) {
  rig_.frame_node(poses_, 0, kAspect);
  const passes::View view = rig_.view(poses_, kAspect);
  for (const glm::vec3 at : {glm::vec3(-4, 2, -1), glm::vec3(3, -2, 2)}) {
    const glm::vec2 ndc = glm::abs(ndc_of(view, at));
    EXPECT_LT(std::max(ndc.x, ndc.y), 1);
  }
}

TEST_F(Cameras, FreeCameraFollowsNode) {
  rig_.let_go(poses_);
  rig_.follow(poses_, 1);
  const glm::vec3 before = rig_.view(poses_, kAspect).eye_world;
  scene::Scene moved = scene_;  // an ancestor moves it, too
  for (scene::Node& node : moved.nodes) node.world_from_node[3] += glm::vec4(1, 2, 3, 0);
  moved.nodes[0].parent_from_node[3] += glm::vec4(1, 2, 3, 0);
  poses_.set_rest(state::rest_pose(moved));
  rig_.follow(poses_, 1);
  rig_.follow(poses_, 1);
  const glm::vec3 step = rig_.view(poses_, kAspect).eye_world - before;
  EXPECT_NEAR(glm::length(step - glm::vec3(1, 2, 3)), 0, 1e-5f);
  rig_.follow(poses_, 2);  // another node: from its current position
  EXPECT_EQ(rig_.view(poses_, kAspect).eye_world, before + step);
}

TEST_F(Cameras, SceneCameraStaysWhileFollowing) {
  const glm::vec3 before = rig_.view(poses_, kAspect).eye_world;
  rig_.follow(poses_, 1);
  rig_.follow(poses_, 1);
  EXPECT_FALSE(rig_.is_free());
  EXPECT_EQ(rig_.view(poses_, kAspect).eye_world, before);
}

// Both cameras follow the node, wherever the mouse is.
TEST_F(Cameras, StereoCamerasFollowNode) {
  CameraRig left = rig_, right = rig_;
  left.let_go(poses_);
  right.let_go(poses_);
  ViewState view_state;
  view_state.followed = 1;
  CameraMoves moves;
  moves.cursor_px = {1.5f * kImage.x, 10};  // on the right one
  move_cameras(left, &right, moves, view_state, poses_, kImage, 0);
  const glm::vec3 left_before = left.view(poses_, kAspect).eye_world;
  const glm::vec3 right_before = right.view(poses_, kAspect).eye_world;
  scene::Scene moved = scene_;
  for (scene::Node& node : moved.nodes) node.world_from_node[3] += glm::vec4(1, 2, 3, 0);
  moved.nodes[0].parent_from_node[3] += glm::vec4(1, 2, 3, 0);
  poses_.set_rest(state::rest_pose(moved));
  move_cameras(left, &right, moves, view_state, poses_, kImage, 0);
  for (const glm::vec3 step : {left.view(poses_, kAspect).eye_world - left_before,
                               right.view(poses_, kAspect).eye_world - right_before})
    EXPECT_NEAR(glm::length(step - glm::vec3(1, 2, 3)), 0, 1e-5f);
  moves.pan_px = {30, 0};
  const glm::vec3 left_stays = left.view(poses_, kAspect).eye_world;
  move_cameras(left, &right, moves, view_state, poses_, kImage, 0);
  EXPECT_EQ(left.view(poses_, kAspect).eye_world, left_stays);
  moves.cursor_px.x = 5;
  move_cameras(left, &right, moves, view_state, poses_, kImage, 0);
  EXPECT_NE(left.view(poses_, kAspect).eye_world, left_stays);
}

TEST_F(Cameras, FlySpeedFollowsScene) {
  const auto flown = [&](float speed) {
    ViewState view_state;
    view_state.camera_speed = speed;
    CameraRig rig = *CameraRig::create(scene_);
    CameraMoves moves;
    moves.fly = {0, 0, -1};
    const glm::vec3 before = rig.view(poses_, kAspect).eye_world;
    move_camera(rig, moves, view_state, poses_, kImage, 0.05f);
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
  ViewState view_state;
  view_state.selected = 2;
  view_state.commands.frame_selection = true;
  move_camera(rig_, {}, view_state, poses_, kImage, 0);
  EXPECT_TRUE(rig_.is_free());
  EXPECT_FALSE(view_state.commands.frame_selection);
  view_state.commands.camera = 0;
  move_camera(rig_, {}, view_state, poses_, kImage, 0);
  EXPECT_FALSE(rig_.is_free());
  EXPECT_FALSE(view_state.commands.camera);
  view_state.commands.camera = 7;  // no such camera
  move_camera(rig_, {}, view_state, poses_, kImage, 0);
  EXPECT_FALSE(rig_.is_free());
}

// Mouse and keyboard events.
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
  CameraMoves take(bool view_has_mouse = true) {
    return input_.take(std::exchange(pending_, {}), view_has_mouse, view_state_);
  }

  ViewState view_state_;
  ViewInput input_;
  sinks::WindowInput pending_;
  sinks::Modifiers modifiers_;
  glm::vec2 cursor_{0};
};

TEST_F(Inputs, ClickIsNoDrag) {
  move(100, 50);
  press(Button::left, true);
  move(102, 51);  // jitter of the hand
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

TEST_F(Inputs, PanelInputKeepsView) {
  press(Button::left, true);
  move(50, 50);
  add({.kind = Kind::wheel, .wheel = {0, 2}});
  const CameraMoves moves = take(false);
  EXPECT_EQ(moves.orbit_px, glm::vec2(0));
  EXPECT_EQ(moves.zoom_notches, 0);
  press(Button::left, false);
  EXPECT_FALSE(take().click_px);  // it began on a panel
}

TEST_F(Inputs, ReleaseEndsHeldKey) {
  key(sinks::letter('w'));
  EXPECT_EQ(take().fly, glm::vec3(0, 0, -1));
  EXPECT_EQ(take().fly, glm::vec3(0, 0, -1));
  key(sinks::letter('w'), false);
  EXPECT_EQ(take().fly, glm::vec3(0));
  key(sinks::letter('d'));
  add({.kind = Kind::focus, .down = false});
  EXPECT_EQ(take().fly, glm::vec3(0));
}

TEST_F(Inputs, EscapeClosesTheInnermostFirst) {
  view_state_.help = true;
  view_state_.selected = 1;
  type(Key::escape);
  take();
  EXPECT_FALSE(view_state_.help);
  EXPECT_EQ(view_state_.selected, 1u);
  type(Key::escape);
  take();
  EXPECT_EQ(view_state_.selected, scene::kNone);
  EXPECT_FALSE(view_state_.commands.close);
  type(Key::escape);
  take();
  EXPECT_FALSE(view_state_.commands.close);
  modifiers_.control = true;
  type(sinks::letter('q'));
  take();
  EXPECT_TRUE(view_state_.commands.close);
}

TEST_F(Inputs, XAndKShowGuides) {
  type(sinks::letter('x'));
  take();
  EXPECT_TRUE(view_state_.shows_grid);
  EXPECT_FALSE(view_state_.shows_frusta);
  type(sinks::letter('x'));
  type(sinks::letter('k'));
  take();
  EXPECT_FALSE(view_state_.shows_grid);
  EXPECT_TRUE(view_state_.shows_frusta);
}

TEST_F(Inputs, EscapeEndsMeasuringFirst) {
  view_state_.selected = 1;
  type(sinks::letter('m'));
  take();
  EXPECT_TRUE(view_state_.measures);
  view_state_.measured.resize(2);
  type(Key::escape);
  take();
  EXPECT_FALSE(view_state_.measures);
  EXPECT_TRUE(view_state_.measured.empty());
  EXPECT_EQ(view_state_.selected, 1u);
  type(sinks::letter('m'));
  take();
  view_state_.measured.resize(1);
  type(sinks::letter('m'));
  take();
  EXPECT_FALSE(view_state_.measures);
  EXPECT_TRUE(view_state_.measured.empty());
}

TEST_F(Inputs, KeysHideIsolateFollow) {
  for (const char c : {'h', 'i', 't'}) type(sinks::letter(c));
  take();
  EXPECT_TRUE(view_state_.edits.hidden.empty());  // nothing is selected
  view_state_.selected = 5;
  for (const char c : {'h', 'i', 't'}) type(sinks::letter(c));
  take();
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{5});
  EXPECT_EQ(view_state_.edits.isolated, 5u);
  EXPECT_EQ(view_state_.followed, 5u);
  type(sinks::letter('h'));
  type(sinks::letter('t'));
  take();
  EXPECT_TRUE(view_state_.edits.hidden.empty());
  EXPECT_EQ(view_state_.followed, scene::kNone);
  modifiers_.shift = true;
  type(sinks::letter('h'));
  take();
  EXPECT_EQ(view_state_.edits.isolated, scene::kNone);
  type(sinks::letter('f'));
  take();
  EXPECT_TRUE(view_state_.commands.focus_on_point);
  EXPECT_FALSE(view_state_.commands.frame_selection);
}

// Records the calls of keys.
struct RecordedTimeline : replay::TimelineControl {
  replay::TimelineState state{
      .start_ns = 1'000'000'000, .end_ns = 6'000'000'000, .position_ns = 2'500'000'000, .playing = true};
  std::vector<std::string> calls;
  replay::TimelineState timeline() const override { return state; }
  void play() override { calls.push_back("play"); }
  void pause() override { calls.push_back("pause"); }
  void seek(uint64_t ns) override { calls.push_back("seek " + std::to_string(ns / 1'000'000)); }
  Result<void> seek_sim_time(int64_t) override { return {}; }
  void step() override { calls.push_back("step"); }
  void step_back() override { calls.push_back("back"); }
  void set_speed(double) override {}
  void set_looping(bool) override {}
};

TEST_F(Inputs, KeysDriveTheTimeline) {
  RecordedTimeline timeline;
  const auto calls_of = [&](Key k, bool shift = false) {
    modifiers_.shift = shift;
    type(k);
    take();
    timeline.calls.clear();
    control_timeline(view_state_.commands, &timeline);
    return timeline.calls;
  };
  using Calls = std::vector<std::string>;
  EXPECT_EQ(calls_of(Key::space), Calls{"pause"});
  timeline.state.playing = false;
  EXPECT_EQ(calls_of(Key::space), Calls{"play"});
  EXPECT_EQ(calls_of(Key::period), Calls{"step"});
  EXPECT_EQ(calls_of(Key::comma), Calls{"back"});
  EXPECT_EQ(calls_of(Key::right), Calls{"seek 3500"});
  EXPECT_EQ(calls_of(Key::left), Calls{"seek 1500"});
  EXPECT_EQ(calls_of(Key::left, true), Calls{"seek 1000"});  // not before its start
  EXPECT_EQ(calls_of(Key::right, true), Calls{"seek 6000"});
  control_timeline(view_state_.commands, &timeline);
  EXPECT_EQ(timeline.calls.size(), 1u) << "a command is executed once";
  // Held keys repeat, except the toggle.
  modifiers_.shift = false;
  for (const Key k : {Key::right, Key::space})
    add({.kind = Kind::key, .key = k, .down = true, .repeated = true});
  take();
  control_timeline(view_state_.commands, &timeline);
  EXPECT_EQ(timeline.calls.back(), "seek 3500");
  // Without a timeline nothing happens, also later.
  type(Key::space);
  take();
  control_timeline(view_state_.commands, nullptr);
  EXPECT_FALSE(view_state_.commands.toggle_playback);
}

// Also between events: panels read the modifiers in every frame.
TEST_F(Inputs, HeldModifierPersists) {
  PanelInput panels;
  modifiers_.shift = true;
  key(Key::left_shift);
  EXPECT_TRUE(panels.convert(std::exchange(pending_, {}), kImage, 0).held.shift);
  const gui::Input without_events = panels.convert({}, kImage, 0);
  EXPECT_TRUE(without_events.held.shift);
  EXPECT_FALSE(without_events.held.ctrl);
  modifiers_.shift = false;
  key(Key::left_shift, false);
  EXPECT_FALSE(panels.convert(std::exchange(pending_, {}), kImage, 0).held.shift);
  EXPECT_FALSE(panels.convert({}, kImage, 0).held.shift);
}

// Panels see a press a frame after the move to its position, and the release a frame later.
TEST_F(Inputs, KeyWaitsForClicksBeforeIt) {
  const scene::Scene scene = boxes_at({{0, 0, 0}});
  const state::PoseState poses(scene);
  const gui::Shown shown{.scene = scene, .poses = poses};
  gui::Gui gui;
  PanelInput panels;
  const auto frame = [&] {
    gui.frame(panels.convert(std::exchange(pending_, {}), kImage, 0.01f), {}, shown, view_state_);
    pending_.events = panels.take_seen(gui);
    return take(!gui.wants_mouse()).click_px.has_value();
  };
  frame();
  move(450, 300);
  press(Button::left, true);
  press(Button::left, false);
  type(sinks::letter('p'));
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(frame()) << i;
    EXPECT_FALSE(view_state_.commands.screenshot) << i;
  }
  EXPECT_TRUE(frame());
  EXPECT_FALSE(view_state_.commands.screenshot) << "the click may have opened a list, which takes keys";
  frame();
  EXPECT_TRUE(view_state_.commands.screenshot);
}

TEST_F(Inputs, WheelZoomsOrSetsSpeed) {
  add({.kind = Kind::wheel, .wheel = {0, 2}});
  EXPECT_EQ(take().zoom_notches, 2);
  modifiers_.control = true;
  add({.kind = Kind::wheel, .wheel = {0, 1}});
  EXPECT_EQ(take().zoom_notches, 0);
  EXPECT_GT(view_state_.camera_speed, 1);
  for (int i = 0; i < 100; ++i) add({.kind = Kind::wheel, .wheel = {0, -10}});
  take();
  EXPECT_GT(view_state_.camera_speed, 0.01f);
}

TEST_F(Inputs, ControlKeysAreCommands) {
  const auto commands = [&](char letter, bool shift) {
    modifiers_.control = true;
    modifiers_.shift = shift;
    type(sinks::letter(letter));
    key(sinks::letter(letter));
    EXPECT_EQ(take().fly, glm::vec3(0)) << "Ctrl does not fly";
    return std::exchange(view_state_.commands, {});
  };
  EXPECT_TRUE(commands('z', false).undo);
  EXPECT_TRUE(commands('z', true).redo);
  EXPECT_TRUE(commands('y', false).redo);
  EXPECT_TRUE(commands('d', false).duplicate);
  EXPECT_TRUE(commands('s', false).save_overlay);
  const Commands shifted = commands('s', true);
  EXPECT_TRUE(shifted.export_glb);
  EXPECT_FALSE(shifted.save_overlay);
}

}  // namespace
}  // namespace fire3dv::app
