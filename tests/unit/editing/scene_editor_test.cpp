// Test of the editor of a window's scene: steps per interaction, undo and redo by keys, scene replacement,
// and the overlay file.
#include "renderer/editing/scene_editor.h"

#include "tests/unit/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(Editors, ADragIsOneStepAndKeysUndoIt) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  for (int i = 1; i <= 20; ++i) {
    viewer_.transforms[1].translation.x = static_cast<float>(i);
    update(editor, true);
  }
  press('z');  // waits for the end of the drag
  update(editor, true);
  EXPECT_EQ(viewer_.transforms.at(1).translation.x, 20);
  viewer_.commands.undo = false;
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.hidden = {2};
  update(editor);
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.hidden.empty());
  EXPECT_TRUE(viewer_.transforms.contains(1));
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.transforms.empty());
  press('z', true);
  update(editor);
  press('y');
  update(editor);
  EXPECT_EQ(viewer_.transforms.at(1).translation.x, 20);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.facts().redo, "");
  EXPECT_NE(editor.facts().undo.find("visibility"), std::string::npos);
}

TEST_F(Editors, WhatIsSavedIsOpenedAgain) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  viewer_.transforms[2].scale = {1, 2, 3};
  viewer_.hidden = {3};
  viewer_.materials[0] = scene_.materials.empty() ? scene::Material() : scene_.materials[0];
  update(editor);
  EXPECT_FALSE(editor.facts().is_saved);
  press('s');
  update(editor);
  EXPECT_TRUE(editor.facts().is_saved);
  const std::string text = bytes_of(file().path);

  Options options;
  options.headless = true;
  options.overlay = file().path;
  Result<state::EditDocument> document = load_overlay(options);
  ASSERT_TRUE(document.ok()) << document.error().message;
  SceneEditor again(file(), *document);
  gui::Viewer reopened;
  again.begin(reopened, targets());
  EXPECT_EQ(again.take_log_messages().at(0),
            counted(document->size(), "edit") + " of " + file().path.string() + " applied");
  EXPECT_EQ(edits_of(reopened), edits_of(viewer_));
  EXPECT_TRUE(again.facts().is_saved);
  EXPECT_EQ(again.facts().undo, "");
  reopened.commands.save_overlay = true;
  again.update(reopened, targets(), false);
  EXPECT_EQ(bytes_of(file().path), text);
}

TEST_F(Editors, AFileThatWasNotOpenedIsReplacedOnlyWhenAskedTwice) {
  std::ofstream(file().path) << "of yesterday";
  SceneEditor editor(file(false), {});
  editor.begin(viewer_, targets());
  EXPECT_NE(editor.take_log_messages().at(0).find("is not applied: --overlay"), std::string::npos);
  viewer_.hidden = {1};
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_EQ(bytes_of(file().path), "of yesterday");
  ASSERT_EQ(editor.take_log_messages().size(), 1u);
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_NE(bytes_of(file().path), "of yesterday");
  EXPECT_EQ(editor.take_log_messages().at(0),
            "1 edit saved to " + file().path.string() + "; open it with --overlay " + file().path.string());
  // Where nothing can be written the edits stay, with an error.
  SceneEditor lost({folder_ / "no such folder" / "a.json", "a", true}, {});
  viewer_.commands.save_overlay = true;
  update(lost);
  EXPECT_NE(lost.take_log_messages().at(0).find("no such folder"), std::string::npos);
  SceneEditor nowhere({}, {});
  viewer_.commands.save_overlay = true;
  update(nowhere);
  EXPECT_NE(nowhere.take_log_messages().at(0).find("--overlay"), std::string::npos);
}

// A node that a scene lacks keeps its edits for a scene that has it.
TEST_F(Editors, EditsOfMissingNodesWaitAndAreReported) {
  SceneEditor editor(file(), {});
  editor.begin(viewer_, targets());
  viewer_.hidden = {1, 3};
  viewer_.selected = 3;
  update(editor);
  scene::Scene less = scene_;
  less.nodes.erase(less.nodes.begin() + 3);
  editor.replace_scene(viewer_, scene_, less, nullptr);
  EXPECT_EQ(viewer_.hidden, std::set<uint32_t>{1});
  EXPECT_EQ(viewer_.selected, scene::kNone);
  editor.update(viewer_, {less, state::NodeNames(less)}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a replaced scene is no step";
  EXPECT_EQ(editor.history().document().size(), 2u);
  editor.replace_scene(viewer_, less, scene_, nullptr);
  EXPECT_EQ(viewer_.hidden, (std::set<uint32_t>{1, 3}));
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(viewer_.hidden.empty());

  state::EditDocument document;
  document[{state::EditedObject::node, "nobody", 0, state::EditedProperty::visible}] = false;
  SceneEditor opened(file(), document);
  gui::Viewer viewer;
  opened.begin(viewer, targets());
  EXPECT_NE(opened.take_log_messages().at(0).find("nobody"), std::string::npos);
  EXPECT_TRUE(viewer.hidden.empty());
}

TEST_F(Editors, JointsKeepTheirPositionsByNameWhenTheFileIsReloaded) {
  const auto robot_with = [](const char* joints) {
    const std::string file =
        R"({"nodes": [{"name": "world", "extras": {"fire3dv": {"robot": {"version": 1,
            "bodies": [{"node": "world"}], "joints": [)" +
        std::string(joints) + R"(], "poses": []}}}}]})";
    return state::RobotPose(robot::read_robot(std::as_bytes(std::span(file)), true).value());
  };
  const std::string lift = R"({"name": "lift", "type": "prismatic", "node": "world", "axis": [0, 1, 0]})";
  const std::string swing = R"({"name": "swing", "type": "revolute", "node": "world", "axis": [0, 0, 1]})";
  const state::RobotPose before = robot_with((lift + "," + swing).c_str());
  const state::RobotPose after = robot_with((swing + "," + lift).c_str());
  const state::RobotPose without = robot_with(swing.c_str());
  SceneEditor editor(file(), {});
  editor.begin(viewer_, {scene_, names_, &before});
  viewer_.joints[0] = {0.5};
  editor.update(viewer_, {scene_, names_, &before}, false);
  ASSERT_EQ(editor.history().undo_steps(), 1u);

  editor.replace_robot(viewer_, scene_, &before, &after);
  EXPECT_EQ(viewer_.joints, (state::JointPositions{{1, {0.5}}}));
  editor.update(viewer_, {scene_, names_, &after}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";

  editor.replace_robot(viewer_, scene_, &after, &without);
  EXPECT_TRUE(viewer_.joints.empty());
  editor.update(viewer_, {scene_, names_, &without}, false);
  editor.replace_robot(viewer_, scene_, &without, &before);
  EXPECT_EQ(viewer_.joints, (state::JointPositions{{0, {0.5}}})) << "an edit without its joint waits";
}

TEST_F(Editors, TheOverlayFileIsBesideTheSceneUnlessNamed) {
  Options options;
  options.scene = folder_ / "demo.glb";
  EXPECT_EQ(overlay_file(options, true).path, folder_ / "demo.glb.overlay.json");
  EXPECT_TRUE(overlay_file(options, false).path.empty());
  options.overlay = folder_ / "mine.json";
  EXPECT_EQ(overlay_file(options, false).path, options.overlay);
  EXPECT_TRUE(load_overlay(options).ok()) << "a window saves it";
  options.headless = true;
  EXPECT_FALSE(load_overlay(options).ok());
  std::ofstream(options.overlay) << R"({"fire3dv_overlay": {"version": 1, "edits": [{"node": "a"}]}})";
  const Result<state::EditDocument> bad = load_overlay(options);
  ASSERT_FALSE(bad.ok());
  EXPECT_NE(bad.error().message.find("mine.json: edits[0]"), std::string::npos) << bad.error().message;
}

}  // namespace
}  // namespace fire3dv::app
