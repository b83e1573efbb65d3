// Test of the editor of a window's scene: steps per interaction, undo and redo by keys, scene replacement,
// and the overlay file.
#include "renderer/editing/edit_session.h"

#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(Editors, DragIsOneUndoStep) {
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  for (int i = 1; i <= 20; ++i) {
    viewer_.edits.transforms[1].translation.x = static_cast<float>(i);
    update(editor, true);
  }
  press('z');  // waits for the end of the drag
  update(editor, true);
  EXPECT_EQ(viewer_.edits.transforms.at(1).translation.x, 20);
  viewer_.commands.undo = false;
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.edits.hidden = {2};
  update(editor);
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.edits.hidden.empty());
  EXPECT_TRUE(viewer_.edits.transforms.contains(1));
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.edits.transforms.empty());
  press('z', true);
  update(editor);
  press('y');
  update(editor);
  EXPECT_EQ(viewer_.edits.transforms.at(1).translation.x, 20);
  EXPECT_EQ(viewer_.edits.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.facts().redo, "");
  EXPECT_NE(editor.facts().undo.find("visibility"), std::string::npos);
}

TEST_F(Editors, WhatIsSavedIsOpenedAgain) {
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  viewer_.edits.transforms[2].scale = {1, 2, 3};
  viewer_.edits.hidden = {3};
  viewer_.edits.materials[0] =
      scene::factors_of(scene_.materials.empty() ? scene::Material() : scene_.materials[0]);
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
  gui::ViewState reopened;
  EditSession again(reopened, file(), *document);
  again.begin(targets());
  EXPECT_EQ(again.take_log_messages().at(0),
            counted(document->size(), "edit") + " of " + file().path.string() + " applied");
  EXPECT_EQ(reopened.edits, viewer_.edits);
  EXPECT_TRUE(again.facts().is_saved);
  EXPECT_EQ(again.facts().undo, "");
  reopened.commands.save_overlay = true;
  again.update(targets(), false);
  EXPECT_EQ(bytes_of(file().path), text);
}

TEST_F(Editors, UnopenedFileNeedsConfirmation) {
  std::ofstream(file().path) << "of yesterday";
  EditSession editor(viewer_, file(false), {});
  editor.begin(targets());
  EXPECT_NE(editor.take_log_messages().at(0).find("is not applied: --overlay"), std::string::npos);
  viewer_.edits.hidden = {1};
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
  EditSession lost(viewer_, {folder_ / "no such folder" / "a.json", "a", true}, {});
  viewer_.commands.save_overlay = true;
  update(lost);
  EXPECT_NE(lost.take_log_messages().at(0).find("no such folder"), std::string::npos);
  EditSession nowhere(viewer_, {}, {});
  viewer_.commands.save_overlay = true;
  update(nowhere);
  EXPECT_NE(nowhere.take_log_messages().at(0).find("--overlay"), std::string::npos);
}

// Two windows with one overlay file: the second learns of the edits of the first before it replaces them.
TEST_F(Editors, FileOfAnotherProgramNeedsConfirmation) {
  for (const bool exists : {false, true}) {
    fs::remove(file().path);
    if (exists) {
      ASSERT_TRUE(state::save_overlay(file().path, {}, "boxes.glb").ok());
    }
    gui::ViewState others_viewer;
    EditSession first(viewer_, file(), {}), second(others_viewer, file(), {});
    first.begin(targets());
    second.begin(targets());
    viewer_.edits.hidden = {1};
    viewer_.commands.save_overlay = true;
    update(first);
    const std::string saved = bytes_of(file().path);
    first.take_log_messages();
    viewer_.commands.save_overlay = true;
    update(first);
    EXPECT_NE(first.take_log_messages().at(0).find("1 edit saved"), std::string::npos) << "its own file";
    second.take_log_messages();
    others_viewer.edits.hidden = {2};
    others_viewer.commands.save_overlay = true;
    update(second);
    EXPECT_EQ(bytes_of(file().path), saved);
    EXPECT_FALSE(second.facts().is_saved);
    EXPECT_NE(second.take_log_messages().at(0).find("save again to replace"), std::string::npos);
    // Another change needs another confirmation.
    viewer_.edits.hidden = {1, 3};
    viewer_.commands.save_overlay = true;
    update(first);
    const std::string saved_again = bytes_of(file().path);
    EXPECT_NE(saved_again, saved);
    others_viewer.commands.save_overlay = true;
    update(second);
    EXPECT_EQ(bytes_of(file().path), saved_again);
    others_viewer.commands.save_overlay = true;
    update(second);
    EXPECT_NE(bytes_of(file().path), saved_again);
    EXPECT_TRUE(second.facts().is_saved);
    viewer_.edits.hidden.clear();
  }
}

TEST_F(Editors, SaveAsChoosesAnotherFile) {
  EditSession editor(viewer_, {folder_ / "no such folder" / "a.json", "a", true}, {});
  editor.begin(targets());
  viewer_.edits.hidden = {1};
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_FALSE(editor.facts().is_saved);
  std::ofstream(folder_ / "b.json") << "of yesterday";
  viewer_.commands.save_as = folder_ / "b.json";
  update(editor);
  EXPECT_EQ(bytes_of(folder_ / "b.json"), "of yesterday") << "confirmed by a second request";
  viewer_.commands.save_as = folder_ / "b.json";
  update(editor);
  EXPECT_NE(bytes_of(folder_ / "b.json"), "of yesterday");
  EXPECT_TRUE(editor.facts().is_saved);
  EXPECT_EQ(editor.facts().file, (folder_ / "b.json").string());
  const std::string saved = bytes_of(folder_ / "b.json");
  viewer_.edits.hidden = {1, 2};
  viewer_.commands.save_overlay = true;
  update(editor);
  EXPECT_NE(bytes_of(folder_ / "b.json"), saved);
}

// A node that a scene lacks keeps its edits for a scene that has it.
TEST_F(Editors, EditsOfMissingNodesWait) {
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  viewer_.edits.hidden = {1, 3};
  viewer_.selected = 3;
  update(editor);
  scene::Scene less = scene_;
  less.nodes.erase(less.nodes.begin() + 3);
  editor.replace_scene(scene_, less, nullptr);
  EXPECT_EQ(viewer_.edits.hidden, std::set<uint32_t>{1});
  EXPECT_EQ(viewer_.selected, scene::kNone);
  editor.update({less, state::NodeNames(less)}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a replaced scene is no step";
  EXPECT_EQ(editor.history().document().size(), 2u);
  editor.replace_scene(less, scene_, nullptr);
  EXPECT_EQ(viewer_.edits.hidden, (std::set<uint32_t>{1, 3}));
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  viewer_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(viewer_.edits.hidden.empty());

  state::EditDocument document;
  document[{state::EditedObject::node, "nobody", 0, state::EditedProperty::visible}] = false;
  gui::ViewState viewer;
  EditSession opened(viewer, file(), document);
  opened.begin(targets());
  EXPECT_NE(opened.take_log_messages().at(0).find("nobody"), std::string::npos);
  EXPECT_TRUE(viewer.edits.hidden.empty());
}

TEST_F(Editors, ReloadKeepsJointPositions) {
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
  EditSession editor(viewer_, file(), {});
  editor.begin({scene_, names_, &before});
  viewer_.edits.joints[0] = {0.5};
  editor.update({scene_, names_, &before}, false);
  ASSERT_EQ(editor.history().undo_steps(), 1u);

  editor.replace_robot(scene_, &before, &after);
  EXPECT_EQ(viewer_.edits.joints, (state::JointPositions{{1, {0.5}}}));
  editor.update({scene_, names_, &after}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";

  editor.replace_robot(scene_, &after, &without);
  EXPECT_TRUE(viewer_.edits.joints.empty());
  editor.update({scene_, names_, &without}, false);
  editor.replace_robot(scene_, &without, &before);
  EXPECT_EQ(viewer_.edits.joints, (state::JointPositions{{0, {0.5}}})) << "an edit without its joint waits";
}

TEST_F(Editors, OverlayFileIsBesideScene) {
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
