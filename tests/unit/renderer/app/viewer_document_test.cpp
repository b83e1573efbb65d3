// Test of scene replacement in the viewer: the user's edits carry over by path, and dropped files replace
// their kind.
#include <gtest/gtest.h>

#include <fstream>
#include <initializer_list>
#include <span>
#include <thread>
#include <vector>

#include "renderer/app/document.h"
#include "renderer/editing/view_transfer.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {
namespace {

void transfer(gui::ViewState& viewer, const scene::Scene& before, const scene::Scene& after,
              std::span<const state::AddedMaterials> added_before = {},
              std::span<const state::AddedMaterials> added_after = {}) {
  const state::NodeNames names_before(before), names_after(after);
  transfer_by_key(viewer, {before, names_before, nullptr, added_before},
                  {after, names_after, nullptr, added_after});
}

TEST(Viewers, SamePathIsKeptInNextScene) {
  const scene::Scene before = boxes_at({{0, 0, 0}, {1, 0, 0}});
  scene::Scene after = boxes_at({{0, 0, 0}});
  after.nodes[0].path = "other";           // at the index of "top"
  after.nodes.push_back(before.nodes[2]);  // "top/box1" is the last one
  gui::ViewState viewer;
  viewer.selected = 2;
  viewer.edits.isolated = 0;
  viewer.followed = 99;
  viewer.edits.hidden = {0, 1, 2};
  viewer.edits.lights[2] = {};
  viewer.edits.materials[0] = {};
  viewer.edits.materials[7] = {};
  transfer(viewer, before, after);
  EXPECT_EQ(viewer.selected, 3u);
  EXPECT_EQ(viewer.edits.isolated, scene::kNone);
  EXPECT_EQ(viewer.followed, scene::kNone);
  EXPECT_EQ(viewer.edits.hidden, (std::set<uint32_t>{1, 3}));
  EXPECT_TRUE(viewer.edits.lights.contains(3));
  EXPECT_EQ(viewer.edits.materials.size(), 1u);
}

TEST(Viewers, LightOfOtherKindIsDropped) {
  scene::Scene before = boxes_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  scene::Light bulb, sun;
  sun.type = scene::LightType::directional;
  before.lights = {bulb, sun};
  for (const uint32_t node : {1, 2, 3}) before.nodes[node].light = 0;
  scene::Scene after = before;
  after.nodes[2].light = scene::kNone;
  after.nodes[3].light = 1;
  gui::ViewState viewer;
  for (const uint32_t node : {1, 2, 3}) viewer.edits.lights[node] = bulb;
  transfer(viewer, before, after);
  ASSERT_EQ(viewer.edits.lights.size(), 1u);
  EXPECT_TRUE(viewer.edits.lights.contains(1));
}

// Materials of added files, whatever their numbers are, and those of the file itself stay apart.
TEST(Viewers, KeepMaterialsByTheirFile) {
  scene::Scene before = boxes_at({{0, 0, 0}});
  before.materials.assign(4, {});
  before.materials[1].name = "steel";
  before.materials[2].name = before.materials[3].name = "wood";
  scene::Scene after = before;
  after.materials.insert(after.materials.begin() + 1, scene::Material{});
  after.materials[1].name = "wood";  // of the file itself
  const std::vector<state::AddedMaterials> chair_and_table{{"chair", 2, 1}, {"table", 3, 1}};
  const std::vector<state::AddedMaterials> chair{{"chair", 3, 1}};
  gui::ViewState viewer;
  for (const uint32_t material : {0, 1, 2, 3})
    viewer.edits.materials[material].roughness = static_cast<float>(material) / 4;
  transfer(viewer, before, after, chair_and_table, chair);
  ASSERT_EQ(viewer.edits.materials.size(), 3u)
      << "the table is gone, and the file's wood is another material";
  EXPECT_EQ(viewer.edits.materials.at(0).roughness, 0);
  EXPECT_EQ(viewer.edits.materials.at(2).roughness, 0.25f);
  EXPECT_EQ(viewer.edits.materials.at(3).roughness, 0.5f);
}

// Instances have no path.
TEST(Viewers, KeepInstancesByTheirNode) {
  const auto with_instances = [](std::initializer_list<uint32_t> parents) {
    scene::Scene scene = boxes_at({{0, 0, 0}, {1, 0, 0}});
    for (const uint32_t parent : parents) scene.nodes.emplace_back().parent = parent;
    return scene;
  };
  const scene::Scene before = with_instances({1, 1, 2}), after = with_instances({2, 1, 1});
  gui::ViewState viewer;
  viewer.selected = 4;
  viewer.edits.hidden = {5, 6};
  transfer(viewer, before, after);
  EXPECT_EQ(viewer.selected, 5u);
  EXPECT_EQ(viewer.edits.hidden, (std::set<uint32_t>{4, 6}));
}

TEST(Viewers, IsolationHidesOthersAndIsUndone) {
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
  EXPECT_TRUE(edits.is_hidden(2));  // still hidden by a stream
  EXPECT_FALSE(edits.is_removed(2));
  edits.set(scene, {});
  EXPECT_TRUE(edits.hidden().empty());
}

// A dropped file is loaded and checked before it replaces the shown document.
TEST(Viewers, UnreadableFileIsReported) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "fire3dv_viewer_test_dropped.gltf";
  std::ofstream(file) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                            "nodes": [{"name": "lonely"}]})";
  Options options;
  options.scene = file;
  const CacheLocations places;
  Result<std::unique_ptr<Document>> now = Document::open(options, places);
  ASSERT_TRUE(now.ok());
  ASSERT_TRUE((*now)->load().wait().ok());
  bool can = false;
  DocumentLoader next(**now, places, [&](const scene::Scene& scene) -> Result<void> {
    EXPECT_EQ(scene.nodes.at(0).name, "lonely");
    if (can) return {};
    return Error{"the device takes no more"};
  });
  const auto ready_in_the_end = [&] {
    next.open(file);
    EXPECT_EQ(next.take_log_messages().size(), 1u);
    for (int i = 0; i < 10'000; ++i) {
      if (next.is_ready()) return true;
      const std::vector<std::string> notes = next.take_log_messages();
      if (!notes.empty()) {
        EXPECT_EQ(notes, std::vector<std::string>{"error: the device takes no more"});
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << "it is loading still";
    return false;
  };
  EXPECT_FALSE(ready_in_the_end());
  EXPECT_EQ(next.take(), nullptr);
  can = true;
  EXPECT_TRUE(ready_in_the_end());
  next.open(file);  // again, while it is held for unsaved edits
  EXPECT_TRUE(next.take_log_messages().empty());
  EXPECT_TRUE(next.is_ready());
  EXPECT_NE(next.take(), nullptr);
  std::filesystem::remove(file);
}

TEST(Viewers, DroppedFileReplacesItsKind) {
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

// Changes the playout of a running stream: no frame is lost or incomplete.
TEST(Viewers, StreamDisplayModeIsSwitched) {
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
  EXPECT_FALSE(push(2, {2}, {0}));  // a partial frame directly afterwards
  EXPECT_EQ(x(1), 1);               // not due yet
  poses.advance(40 * kMs);
  EXPECT_EQ(x(1), 2);
  EXPECT_EQ(x(2), 10);

  push(3, {3, 30});
  poses.interpolate(id, 500 * kMs);  // another delay
  push(4, {4}, {0});
  poses.show_newest(id, 45 * kMs);  // pending frames are shown immediately
  EXPECT_EQ(x(1), 4);
  EXPECT_EQ(x(2), 30);
  EXPECT_TRUE(push(5, {5}, {0}));
  EXPECT_EQ(x(1), 5);
  EXPECT_EQ(x(2), 30);
}

}  // namespace
}  // namespace fire3dv::app
