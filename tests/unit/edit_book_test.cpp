// What edits of several streams make of a scene: whose count, what is undone, and what is said of those
// without effect. No GPU.
#include "renderer/state/edit_book.h"

#include <gtest/gtest.h>

namespace fire3dv::state {
namespace {

// A table with a cup on it and a lamp that the file has; ball: a mesh.
scene::Scene room() {
  scene::Scene scene;
  scene.meshes.emplace_back();
  scene::Light light;
  light.radius_m = 0.25f;
  light.name = "bulb";
  scene.lights.push_back(light);
  const auto add = [&](const char* name, uint32_t parent) {
    scene::Node& node = scene.nodes.emplace_back();
    node.name = node.path = name;
    node.parent = parent;
    return &node;
  };
  add("table", scene::kNone);
  add("cup", 0);
  add("lamp", 0)->light = 0;
  add("ball", scene::kNone)->mesh = 0;
  return scene;
}
enum : uint32_t { kTable, kCup, kLamp, kBall };

class EditBookTest : public testing::Test {
 protected:
  StreamId stream(uint64_t epoch, std::vector<std::string> drives = {"nothing"}) {
    wire::StreamDescription description;
    description.epoch = epoch;
    description.adapter_name = "stream " + std::to_string(epoch);
    description.node_names = std::move(drives);
    return poses_.add_stream(description);
  }
  void edit(StreamId id, const std::string& node, wire::Property property, wire::EditValue value) {
    poses_.apply(id, {poses_.streams()[id].epoch, ++version_, node, property, std::move(value)});
  }
  void hide(StreamId id, const std::string& node, bool visible = false) {
    edit(id, node, wire::Property::visible, wire::Visible{visible});
  }
  const scene::SceneEdits& resolved() {
    book_.take(poses_.take_scene_changes());
    edits_.set(scene_, book_.resolve(scene_, poses_));
    return edits_;
  }

  const scene::Scene scene_ = room();
  PoseState poses_{scene_};
  EditBook book_;
  scene::SceneEdits edits_;
  uint64_t version_ = 0;
};

TEST_F(EditBookTest, WhatIsBelowAHiddenNodeIsHiddenUntilItIsShownAgain) {
  const StreamId id = stream(1);
  hide(id, "table");
  EXPECT_TRUE(resolved().is_hidden(kTable));
  EXPECT_TRUE(edits_.is_hidden(kCup));
  EXPECT_FALSE(edits_.is_hidden(kBall));
  EXPECT_EQ(edits_.revisions().visible, 1u);
  hide(id, "cup");  // hidden already
  EXPECT_EQ(resolved().revisions().visible, 1u);
  hide(id, "table", true);
  EXPECT_FALSE(resolved().is_hidden(kTable));
  EXPECT_TRUE(edits_.is_hidden(kCup));
  edit(id, "cup", wire::Property::visible, wire::Cleared{});
  EXPECT_FALSE(resolved().is_hidden(kCup));
  EXPECT_TRUE(edits_.hidden().empty());
  EXPECT_EQ(edits_.revisions(), (scene::EditRevisions{.visible = 3}));
}

TEST_F(EditBookTest, LightsTakeWhatTheWireSaysAndKeepTheRest) {
  const StreamId id = stream(1);
  wire::Light light;
  light.kind = wire::LightKind::spot;
  light.color_rgb = {0.5f, 0.25f, 1};
  light.intensity = 7;
  light.range_m = 3;
  light.inner_cone_rad = 0.1f;
  light.outer_cone_rad = 0.2f;
  light.casts_shadow = false;
  edit(id, "lamp", wire::Property::light, light);
  edit(id, "cup", wire::Property::light, light);  // a new one
  const std::vector<scene::PlacedLight> lights = scene::lights_of(scene_, &resolved());
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_EQ(lights[0].node, kCup);
  EXPECT_EQ(lights[1].node, kLamp);
  EXPECT_EQ(lights[0].light.radius_m, 0);
  scene::Light expected;
  expected.name = "bulb";
  expected.type = scene::LightType::spot;
  expected.color = {0.5f, 0.25f, 1};
  expected.intensity = 7;
  expected.range_m = 3;
  expected.radius_m = 0.25f;
  expected.inner_cone_rad = 0.1f;
  expected.outer_cone_rad = 0.2f;
  expected.casts_shadow = false;
  EXPECT_EQ(lights[1].light, expected);
  EXPECT_EQ(scene::lights_of(scene_, nullptr).size(), 1u);
}

TEST_F(EditBookTest, ARemovedNodeTakesLightsWithItAndAClearedOneIsThereAgain) {
  const StreamId id = stream(1);
  edit(id, "table", wire::Property::node, wire::NodeRemoved{});
  EXPECT_TRUE(resolved().is_hidden(kCup));
  EXPECT_TRUE(scene::lights_of(scene_, &edits_).empty());
  EXPECT_EQ(edits_.revisions().light, 1u);
  edit(id, "table", wire::Property::node, wire::Cleared{});
  EXPECT_FALSE(resolved().is_hidden(kCup));
  EXPECT_EQ(scene::lights_of(scene_, &edits_).size(), 1u);
}

TEST_F(EditBookTest, ColoursAndCamerasAreOfTheirNode) {
  const StreamId id = stream(1);
  edit(id, "ball", wire::Property::base_color, wire::BaseColor{{0.1f, 0.2f, 0.3f, 0.4f}});
  edit(id, "cup", wire::Property::camera, wire::Camera{1.1f, 0.2f, 50, 2});
  resolved();
  EXPECT_EQ(edits_.nodes().at(kBall).base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  ASSERT_NE(edits_.camera_at(kCup), nullptr);
  EXPECT_EQ(edits_.camera_at(kCup)->vertical_fov_rad, 1.1f);
  EXPECT_EQ(edits_.camera_at(kCup)->near_m, 0.2f);
  EXPECT_EQ(edits_.camera_at(kCup)->far_m, 50);
  EXPECT_EQ(edits_.camera_at(kCup)->exposure, 2);
  EXPECT_EQ(edits_.camera_at(kLamp), nullptr);
  edit(id, "cup", wire::Property::base_color, wire::BaseColor{});
  resolved();
  EXPECT_EQ(book_.faults().unfit, 1u) << "no mesh";
  EXPECT_EQ(edits_.revisions(), (scene::EditRevisions{.base_color = 1, .camera = 1}));
}

TEST_F(EditBookTest, TheOlderStreamKeepsANodeAndGivesItBack) {
  const StreamId older = stream(1), younger = stream(2);
  hide(younger, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall));
  hide(older, "ball", true);
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_EQ(book_.faults().conflicting, 1u);
  edit(younger, "ball", wire::Property::base_color, wire::BaseColor{});  // another property of the same node
  EXPECT_FALSE(resolved().nodes().at(kBall).base_color.has_value());
  EXPECT_EQ(book_.faults().conflicting, 2u);
  resolved();
  EXPECT_EQ(book_.faults().conflicting, 2u) << "each is counted once";
  EXPECT_EQ(book_.take_notes().size(), 1u) << "and told once";
  poses_.remove_stream(older);
  EXPECT_TRUE(resolved().is_hidden(kBall));
  EXPECT_TRUE(edits_.nodes().at(kBall).base_color.has_value());
  poses_.remove_stream(younger);
  EXPECT_TRUE(resolved().nodes().empty());
  EXPECT_TRUE(book_.empty());
}

TEST_F(EditBookTest, WhoMovesANodeIsAskedToo) {
  const StreamId driver = stream(1, {"ball"}), other = stream(2);
  hide(other, "ball");
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_EQ(book_.faults().conflicting, 1u);
  hide(driver, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall)) << "its own";
  poses_.remove_stream(driver);
  EXPECT_TRUE(resolved().is_hidden(kBall)) << "the other one's, now";
}

TEST_F(EditBookTest, WhatHasNoNodeIsCountedAndDoesNoHarm) {
  const StreamId id = stream(1);
  hide(id, "nobody");
  hide(id, "ball");
  EXPECT_TRUE(resolved().is_hidden(kBall));
  EXPECT_EQ(book_.faults().unmatched, 1u);
  const std::vector<std::string> notes = book_.take_notes();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("nobody"), std::string::npos);
}

// Ids are given out again.
TEST_F(EditBookTest, AStreamThatTakesThePlaceOfAnotherHasNoneOfItsEdits) {
  const StreamId first = stream(1);
  hide(first, "ball");
  resolved();
  poses_.remove_stream(first);
  const StreamId second = stream(2);
  ASSERT_EQ(second, first);
  hide(second, "cup");
  EXPECT_FALSE(resolved().is_hidden(kBall));
  EXPECT_TRUE(edits_.is_hidden(kCup));
}

}  // namespace
}  // namespace fire3dv::state
