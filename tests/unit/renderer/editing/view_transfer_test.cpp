// Test of the transfer of selections and edits to another scene: they carry over by path.
#include "renderer/editing/view_transfer.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <set>
#include <span>
#include <vector>

#include "renderer/scene/model/scene_edits.h"
#include "tests/unit/renderer/scene/clusters/boxes_scene.h"

namespace fire3dv::app {
namespace {

void transfer(ViewState& view_state, const scene::Scene& before, const scene::Scene& after,
              std::span<const state::AddedMaterials> added_before = {},
              std::span<const state::AddedMaterials> added_after = {}) {
  const state::NodeNames names_before(before), names_after(after);
  transfer_by_key(view_state, {before, names_before, nullptr, added_before},
                  {after, names_after, nullptr, added_after});
}

TEST(ViewTransfer, SamePathIsKeptInNextScene) {
  const scene::Scene before = boxes_at({{0, 0, 0}, {1, 0, 0}});
  scene::Scene after = boxes_at({{0, 0, 0}});
  after.nodes[0].path = "other";           // at the index of "top"
  after.nodes.push_back(before.nodes[2]);  // "top/box1" is the last one
  ViewState view_state;
  view_state.selected = 2;
  view_state.edits.isolated = 0;
  view_state.followed = 99;
  view_state.edits.hidden = {0, 1, 2};
  view_state.edits.lights[2] = {};
  view_state.edits.materials[0] = {};
  view_state.edits.materials[7] = {};
  transfer(view_state, before, after);
  EXPECT_EQ(view_state.selected, 3u);
  EXPECT_EQ(view_state.edits.isolated, scene::kNone);
  EXPECT_EQ(view_state.followed, scene::kNone);
  EXPECT_EQ(view_state.edits.hidden, (std::set<uint32_t>{1, 3}));
  EXPECT_TRUE(view_state.edits.lights.contains(3));
  EXPECT_EQ(view_state.edits.materials.size(), 1u);
}

TEST(ViewTransfer, LightOfOtherKindIsDropped) {
  scene::Scene before = boxes_at({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  scene::Light bulb, sun;
  sun.type = scene::LightType::directional;
  before.lights = {bulb, sun};
  for (const uint32_t node : {1, 2, 3}) before.nodes[node].light = 0;
  scene::Scene after = before;
  after.nodes[2].light = scene::kNone;
  after.nodes[3].light = 1;
  ViewState view_state;
  for (const uint32_t node : {1, 2, 3}) view_state.edits.lights[node] = bulb;
  transfer(view_state, before, after);
  ASSERT_EQ(view_state.edits.lights.size(), 1u);
  EXPECT_TRUE(view_state.edits.lights.contains(1));
}

// Materials of added files, whatever their numbers are, and those of the file itself stay apart.
TEST(ViewTransfer, KeepMaterialsByTheirFile) {
  scene::Scene before = boxes_at({{0, 0, 0}});
  before.materials.assign(4, {});
  before.materials[1].name = "steel";
  before.materials[2].name = before.materials[3].name = "wood";
  scene::Scene after = before;
  after.materials.insert(after.materials.begin() + 1, scene::Material{});
  after.materials[1].name = "wood";  // of the file itself
  const std::vector<state::AddedMaterials> chair_and_table{{"chair", 2, 1}, {"table", 3, 1}};
  const std::vector<state::AddedMaterials> chair{{"chair", 3, 1}};
  ViewState view_state;
  for (const uint32_t material : {0, 1, 2, 3})
    view_state.edits.materials[material].roughness = static_cast<float>(material) / 4;
  transfer(view_state, before, after, chair_and_table, chair);
  ASSERT_EQ(view_state.edits.materials.size(), 3u)
      << "the table is gone, and the file's wood is another material";
  EXPECT_EQ(view_state.edits.materials.at(0).roughness, 0);
  EXPECT_EQ(view_state.edits.materials.at(2).roughness, 0.25f);
  EXPECT_EQ(view_state.edits.materials.at(3).roughness, 0.5f);
}

// Instances have no path.
TEST(ViewTransfer, KeepInstancesByTheirNode) {
  const auto with_instances = [](std::initializer_list<uint32_t> parents) {
    scene::Scene scene = boxes_at({{0, 0, 0}, {1, 0, 0}});
    for (const uint32_t parent : parents) scene.nodes.emplace_back().parent = parent;
    return scene;
  };
  const scene::Scene before = with_instances({1, 1, 2}), after = with_instances({2, 1, 1});
  ViewState view_state;
  view_state.selected = 4;
  view_state.edits.hidden = {5, 6};
  transfer(view_state, before, after);
  EXPECT_EQ(view_state.selected, 5u);
  EXPECT_EQ(view_state.edits.hidden, (std::set<uint32_t>{4, 6}));
}

TEST(ViewTransfer, IsolationHidesOthersAndIsUndone) {
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

}  // namespace
}  // namespace fire3dv::app
