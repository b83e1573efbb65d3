// Fixture of panel tests: a small scene with one of everything, a stream that drives it, and a recording,
// without a window and a GPU.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/robot/robot_file.h"
#include "renderer/gui/gui.h"
#include "renderer/scene/model/math.h"
#include "renderer/state/edits/node_transform.h"
#include "tests/render/support/scene_builder.h"
#include "tools/lab/bench/panel_facts.h"

namespace fire3dv::test {

class FakeTimeline : public replay::TimelineControl {
 public:
  replay::TimelineState state;
  std::vector<std::string> calls;

  FakeTimeline() {
    state.end_ns = 60'000'000'000;
    state.position_ns = 21'500'000'000;
    state.sim_time_ns = 21'480'000'000;
    state.playing = true;
  }
  replay::TimelineState timeline() const override { return state; }
  void play() override { note("play"); }
  void pause() override { note("pause"); }
  void seek(uint64_t log_time_ns) override { note("seek " + std::to_string(log_time_ns)); }
  Result<void> seek_sim_time(int64_t) override { return {}; }
  void step() override { note("step"); }
  void step_back() override { note("step back"); }
  void set_speed(double speed) override { note("speed " + std::to_string(speed)); }
  void set_looping(bool looping) override { note(looping ? "loop" : "no loop"); }

 private:
  void note(std::string call) { calls.push_back(std::move(call)); }
};

inline scene::Scene gui_scene() {
  SceneBuilder builder;
  scene::Material steel = matte({0.5f, 0.5f, 0.55f});
  steel.name = "steel";
  steel.normal_texture.texture =
      builder.texture(4, 4, false, [](float, float) { return glm::vec4(0.5f, 0.5f, 1, 1); });
  scene::Material leaf = matte({0.2f, 0.6f, 0.2f});
  leaf.name = "leaf";
  leaf.alpha_mode = scene::AlphaMode::mask;
  scene::Material glass = matte({0.7f, 0.8f, 0.9f});
  glass.name = "glass";
  glass.alpha_mode = scene::AlphaMode::blend;
  glass.emissive = {0.2f, 0.2f, 0};
  const uint32_t world = builder.mesh_node("world", builder.quad(builder.material(steel), 4), glm::mat4(1));
  const uint32_t arm =
      builder.mesh_node("arm", builder.box(builder.material(leaf), glm::vec3(0.3f)), at({0, 1, 0}), world);
  builder.mesh_node("hand", builder.sphere(builder.material(glass), 0.4f, 8), at({0.5f, 1, 0}), arm);
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, -1, -0.2f}));
  scene::Light spot;
  spot.type = scene::LightType::spot;
  spot.intensity = 20;
  spot.inner_cone_rad = 0.3f;
  builder.light_node(spot, shining_towards({0, -1, 0}, {1, 3, 1}));
  scene::Light bulb;
  bulb.intensity = 5;
  bulb.range_m = 10;
  bulb.radius_m = 0.1f;
  builder.light_node(bulb, at({-1, 2, 0}));
  builder.camera_node("front", {0, 1, 4}, {0, 0.5f, 0});
  builder.camera_node("above", {0, 5, 0.1f}, {0, 0, 0});
  scene::Scene scene = builder.build();
  scene.variants = {"rusty", "painted"};
  return scene;
}

// Two joints that move the free node "world", and one of "arm", which the stream drives.
inline state::RobotPose gui_robot() {
  constexpr std::string_view kFile = R"({"nodes": [{"name": "world", "children": [1],
    "extras": {"fire3dv": {"robot": {"version": 1,
      "bodies": [{"node": "world"}, {"node": "arm", "parent": "world", "translation": [0, 1, 0]}],
      "joints": [{"name": "lift", "type": "prismatic", "node": "world", "axis": [0, 1, 0]},
                 {"name": "swing", "type": "revolute", "node": "world", "axis": [0, 0, 1], "limits": [-1, 2]},
                 {"name": "elbow", "type": "revolute", "node": "arm", "axis": [0, 0, 1]}],
      "poses": [{"name": "high", "positions": [1, 0, 0]}, {"name": "turned", "positions": [0, 1.5, 0]}]}}}},
    {"name": "arm"}]})";
  return state::RobotPose(robot::read_robot(std::as_bytes(std::span(kFile)), true).value());
}

struct GuiWorld {
  scene::Scene scene;
  state::PoseState poses;
  state::RobotPose robot = gui_robot();
  FakeTimeline timeline;
  gui::Facts facts;
  app::ViewState view_state;
  app::EditFacts editing{"the light of node \"lamp\"",
                         "the transform of node \"arm\"",
                         false,
                         "scene.overlay.json",
                         {"part.glb", "parts/other.gltf"},
                         {},
                         {{"lost", "no node has the path \"nobody\", which it copies"}}};
  std::function<passes::View(float aspect)> image_view;  // null: no gizmo
  std::string clipboard;
  std::vector<std::filesystem::path> recent_files{"/a/shown.glb", "/a/other.glb", "/b/other.glb"};
  // As of a user who has seen scalars: the first ones would unfold the panel Plots.
  gui::Gui gui{{.has_plotted = true},
               {[this] { return clipboard; }, [this](const std::string& text) { clipboard = text; }}};
  glm::vec2 display_px{1280, 720};
  float scale = 1;
  bool replays = true;
  uint64_t scene_number = 1;

  explicit GuiWorld(scene::Scene shown = gui_scene()) : scene(std::move(shown)), poses(scene) {
    facts = bench::panel_facts(0, glm::uvec2(display_px));
    facts.streams[0].marker_namespaces = {{"", 1}, {"contacts", 2}};
    facts.streams[0].more_marker_namespaces = 3;
    wire::StreamDescription description;
    description.adapter_name = "bullet_arm";
    description.epoch = 0x51;
    description.node_names = {"arm", "hand"};
    id_ = poses.add_stream(description);
    const std::vector<wire::Affine3x4> moved{scene::to_affine(at({0, 1.5f, 0})),
                                             scene::to_affine(at({1, 1.5f, 0}))};
    wire::PoseFrameView frame;
    frame.header.epoch = 0x51;
    frame.header.sequence = 1;
    frame.node_count = 2;
    frame.poses = moved;
    poses.push(id_, frame);
    robot.set_scene(scene, poses.names());
    scalars("arm", {{"shoulder", "elbow"}, {"rad", ""}});
    constexpr int64_t kStepNs = 10'000'000;
    for (int64_t step = 0; step <= 100; ++step)
      sample("arm", step * kStepNs,
             {std::sin(0.1 * static_cast<double>(step)), 0.01 * static_cast<double>(step)});
  }

  // Declares scalars of the stream.
  void scalars(const std::string& group, wire::Scalars declared) {
    poses.apply(id_, {0x51, ++version_, group, wire::Property::scalars, std::move(declared)});
    declarations_[group] = version_;
  }
  void sample(const std::string& group, int64_t sim_time_ns, std::vector<double> values) {
    poses.apply(id_, {0x51, ++version_, group, wire::Property::scalar_values,
                      wire::ScalarValues{declarations_.at(group), sim_time_ns, std::move(values)}});
  }

  const ImDrawData& frame(std::vector<gui::Event> events = {}) {
    gui::Input input;
    input.display_px = display_px;
    input.scale = scale;
    input.delta_s = 1.0f / 60;
    input.events = std::move(events);
    const gui::Shown shown{scene,  poses,        nullptr,  scene_number, replays ? &timeline : nullptr,
                           &robot, recent_files, &editing, image_view};
    const ImDrawData& drawn = gui.frame(input, facts, shown, view_state);
    robot.set(view_state.edits.joints);
    state::RestPose rest = state::rest_pose(scene);
    state::apply_transforms(view_state.edits.transforms, scene, rest);
    poses.set_rest(rest);
    return drawn;
  }
  // Panels follow changes of other panels within a few frames.
  const ImDrawData& settle() {
    for (int i = 0; i < 3; ++i) frame();
    return frame();
  }

 private:
  state::StreamId id_ = 0;
  uint64_t version_ = 0;
  std::map<std::string, uint64_t> declarations_;
};

}  // namespace fire3dv::test
