// Test of the editor of a window's scene: steps per interaction, undo and redo, scene replacement,
// and the overlay file.
#include "renderer/editing/edit_session.h"

#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(Editors, DragIsOneUndoStep) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  for (int i = 1; i <= 20; ++i) {
    view_state_.edits.transforms[1].translation.x = static_cast<float>(i);
    update(editor, true);
  }
  view_state_.commands.undo = true;  // waits for the end of the drag
  update(editor, true);
  EXPECT_EQ(view_state_.edits.transforms.at(1).translation.x, 20);
  view_state_.commands.undo = false;
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  view_state_.edits.hidden = {2};
  update(editor);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.hidden.empty());
  EXPECT_TRUE(view_state_.edits.transforms.contains(1));
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.transforms.empty());
  view_state_.commands.redo = true;
  update(editor);
  view_state_.commands.redo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.transforms.at(1).translation.x, 20);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.facts().redo, "");
  EXPECT_NE(editor.facts().undo.find("visibility"), std::string::npos);
}

TEST_F(Editors, WhatIsSavedIsOpenedAgain) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  view_state_.edits.transforms[2].scale = {1, 2, 3};
  view_state_.edits.hidden = {3};
  view_state_.edits.materials[0] =
      scene::factors_of(scene_.materials.empty() ? scene::Material() : scene_.materials[0]);
  update(editor);
  EXPECT_FALSE(editor.facts().is_saved);
  view_state_.commands.save_overlay = true;
  update(editor);
  EXPECT_TRUE(editor.facts().is_saved);
  const std::string text = bytes_of(file().path);

  Result<state::EditDocument> document = state::load_overlay(file().path);
  ASSERT_TRUE(document.ok()) << document.error().message;
  ViewState reopened;
  EditSession again(reopened, file(), *document);
  again.begin(targets());
  EXPECT_EQ(again.take_log_messages().at(0),
            counted(document->size(), "edit") + " of " + file().path.string() + " applied");
  EXPECT_EQ(reopened.edits, view_state_.edits);
  EXPECT_TRUE(again.facts().is_saved);
  EXPECT_EQ(again.facts().undo, "");
  reopened.commands.save_overlay = true;
  again.update(targets(), false);
  EXPECT_EQ(bytes_of(file().path), text);
}

TEST_F(Editors, UnopenedFileNeedsConfirmation) {
  std::ofstream(file().path) << "of yesterday";
  EditSession editor(view_state_, file(false), {});
  editor.begin(targets());
  EXPECT_NE(editor.take_log_messages().at(0).find("is not applied: --overlay"), std::string::npos);
  view_state_.edits.hidden = {1};
  view_state_.commands.save_overlay = true;
  update(editor);
  EXPECT_EQ(bytes_of(file().path), "of yesterday");
  ASSERT_EQ(editor.take_log_messages().size(), 1u);
  view_state_.commands.save_overlay = true;
  update(editor);
  EXPECT_NE(bytes_of(file().path), "of yesterday");
  EXPECT_EQ(editor.take_log_messages().at(0),
            "1 edit saved to " + file().path.string() + "; open it with --overlay " + file().path.string());
  // Where nothing can be written the edits stay, with an error.
  EditSession lost(view_state_, {folder_ / "no such folder" / "a.json", "a", true}, {});
  view_state_.commands.save_overlay = true;
  update(lost);
  EXPECT_NE(lost.take_log_messages().at(0).find("no such folder"), std::string::npos);
  EditSession nowhere(view_state_, {}, {});
  view_state_.commands.save_overlay = true;
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
    ViewState others_view_state;
    EditSession first(view_state_, file(), {}), second(others_view_state, file(), {});
    first.begin(targets());
    second.begin(targets());
    view_state_.edits.hidden = {1};
    view_state_.commands.save_overlay = true;
    update(first);
    const std::string saved = bytes_of(file().path);
    first.take_log_messages();
    view_state_.commands.save_overlay = true;
    update(first);
    EXPECT_NE(first.take_log_messages().at(0).find("1 edit saved"), std::string::npos) << "its own file";
    second.take_log_messages();
    others_view_state.edits.hidden = {2};
    others_view_state.commands.save_overlay = true;
    update(second);
    EXPECT_EQ(bytes_of(file().path), saved);
    EXPECT_FALSE(second.facts().is_saved);
    EXPECT_NE(second.take_log_messages().at(0).find("save again to replace"), std::string::npos);
    // Another change needs another confirmation.
    view_state_.edits.hidden = {1, 3};
    view_state_.commands.save_overlay = true;
    update(first);
    const std::string saved_again = bytes_of(file().path);
    EXPECT_NE(saved_again, saved);
    others_view_state.commands.save_overlay = true;
    update(second);
    EXPECT_EQ(bytes_of(file().path), saved_again);
    others_view_state.commands.save_overlay = true;
    update(second);
    EXPECT_NE(bytes_of(file().path), saved_again);
    EXPECT_TRUE(second.facts().is_saved);
    view_state_.edits.hidden.clear();
  }
}

TEST_F(Editors, SaveAsChoosesAnotherFile) {
  EditSession editor(view_state_, {folder_ / "no such folder" / "a.json", "a", true}, {});
  editor.begin(targets());
  view_state_.edits.hidden = {1};
  view_state_.commands.save_overlay = true;
  update(editor);
  EXPECT_FALSE(editor.facts().is_saved);
  std::ofstream(folder_ / "b.json") << "of yesterday";
  view_state_.commands.save_as = folder_ / "b.json";
  update(editor);
  EXPECT_EQ(bytes_of(folder_ / "b.json"), "of yesterday") << "confirmed by a second request";
  view_state_.commands.save_as = folder_ / "b.json";
  update(editor);
  EXPECT_NE(bytes_of(folder_ / "b.json"), "of yesterday");
  EXPECT_TRUE(editor.facts().is_saved);
  EXPECT_EQ(editor.facts().file, (folder_ / "b.json").string());
  const std::string saved = bytes_of(folder_ / "b.json");
  view_state_.edits.hidden = {1, 2};
  view_state_.commands.save_overlay = true;
  update(editor);
  EXPECT_NE(bytes_of(folder_ / "b.json"), saved);
}

// A node that a scene lacks keeps its edits for a scene that has it.
TEST_F(Editors, EditsOfMissingNodesWait) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  view_state_.edits.hidden = {1, 3};
  view_state_.selected = 3;
  update(editor);
  scene::Scene less = scene_;
  less.nodes.erase(less.nodes.begin() + 3);
  editor.replace_scene(scene_, less, nullptr);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{1});
  EXPECT_EQ(view_state_.selected, scene::kNone);
  editor.update({less, state::NodeNames(less)}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a replaced scene is no step";
  EXPECT_EQ(editor.history().document().size(), 2u);
  editor.replace_scene(less, scene_, nullptr);
  EXPECT_EQ(view_state_.edits.hidden, (std::set<uint32_t>{1, 3}));
  update(editor);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.hidden.empty());

  state::EditDocument document;
  document[{state::EditedObject::node, "nobody", 0, state::EditedProperty::visible}] = false;
  ViewState view_state;
  EditSession opened(view_state, file(), document);
  opened.begin(targets());
  EXPECT_NE(opened.take_log_messages().at(0).find("nobody"), std::string::npos);
  EXPECT_TRUE(view_state.edits.hidden.empty());
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
  EditSession editor(view_state_, file(), {});
  editor.begin({scene_, names_, &before});
  view_state_.edits.joints[0] = {0.5};
  editor.update({scene_, names_, &before}, false);
  ASSERT_EQ(editor.history().undo_steps(), 1u);

  editor.replace_robot(scene_, &before, &after);
  EXPECT_EQ(view_state_.edits.joints, (state::JointPositions{{1, {0.5}}}));
  editor.update({scene_, names_, &after}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";

  editor.replace_robot(scene_, &after, &without);
  EXPECT_TRUE(view_state_.edits.joints.empty());
  editor.update({scene_, names_, &without}, false);
  editor.replace_robot(scene_, &without, &before);
  EXPECT_EQ(view_state_.edits.joints, (state::JointPositions{{0, {0.5}}}))
      << "an edit without its joint waits";
}

}  // namespace
}  // namespace fire3dv::app
