// Test of material variants and render settings as steps of the editor.
#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(Editors, VariantIsAnUndoStep) {
  scene_.variants = {"day", "night"};
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  update(editor);
  view_state_.edits.variant = 0;
  update(editor);
  view_state_.edits.variant = 1;
  update(editor);
  ASSERT_EQ(editor.history().undo_steps(), 2u);
  EXPECT_EQ(editor.facts().undo, "the material variant");
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.variant, 0u);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.variant, scene::kNone);
  view_state_.commands.redo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.variant, 0u);

  // The same variant of another scene has another number; one that is missing waits.
  scene::Scene other = scene_, less = scene_;
  other.variants = {"dusk", "night", "day"};
  less.variants = {"dusk"};
  editor.replace_scene(scene_, other, nullptr);
  EXPECT_EQ(view_state_.edits.variant, 2u);
  editor.replace_scene(other, less, nullptr);
  EXPECT_EQ(view_state_.edits.variant, scene::kNone);
  editor.update({less, names_}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  editor.replace_scene(less, scene_, nullptr);
  EXPECT_EQ(view_state_.edits.variant, 0u);
  // Another choice takes the place of a missing one.
  editor.replace_scene(scene_, less, nullptr);
  view_state_.edits.variant = 0;
  editor.update({less, names_}, false);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("dusk"));
  view_state_.commands.save_overlay = true;
  editor.update({less, names_}, false);

  Result<state::EditDocument> saved = state::load_overlay(file().path);
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  ViewState view_state;
  EditSession reopened(view_state, file(), *saved);
  reopened.begin(targets());
  EXPECT_EQ(view_state.edits.variant, scene::kNone);
  const std::vector<std::string> notes = reopened.take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("the material variant \"dusk\" has no effect"), std::string::npos) << notes[0];
  // --variant replaces that of the file, and is no edit of it.
  (*saved)[state::variant_key()] = "night";
  EditSession named(view_state, file(), *saved);
  named.begin(targets());
  EXPECT_EQ(view_state.edits.variant, 1u);
  EXPECT_EQ(named.facts().undo, "");
  const state::EditDocument variant_alone{{state::variant_key(), "night"}};
  for (const fs::path& path : {fs::path(), folder_ / "new.json"}) {
    EditSession without(view_state, {path, "boxes.glb", !path.empty(), true}, variant_alone);
    without.begin(targets());
    EXPECT_EQ(view_state.edits.variant, 1u);
    EXPECT_TRUE(without.take_log_messages().empty());
  }
}

TEST_F(Editors, RefusedVariantIsNoStep) {
  scene_.variants = {"day", "night"};
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  update(editor);
  view_state_.edits.hidden = {1};
  update(editor);
  view_state_.edits.variant = 0;
  update(editor);
  view_state_.edits.variant = 1;
  update(editor);
  const auto refuse = [&] {  // the scene stays in the variant "day"
    view_state_.edits.variant = 0;
    editor.take_shown_variant(targets());
    update(editor);
  };
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  for (const uint32_t variant : {0u, scene::kNone}) {
    view_state_.commands.undo = true;
    update(editor);
    EXPECT_EQ(view_state_.edits.variant, variant);
  }
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.hidden.empty());
  EXPECT_EQ(editor.history().redo_steps(), 3u);
  for (int i = 0; i < 3; ++i) {
    view_state_.commands.redo = true;
    update(editor);
  }
  EXPECT_EQ(view_state_.edits.variant, 1u) << "it is requested again";
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  view_state_.commands.undo = true;
  update(editor);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.variant, scene::kNone);
  EXPECT_EQ(view_state_.edits.hidden, (std::set<uint32_t>{1}));
}

// Edits and render settings are steps of one history; only edits are saved.
TEST_F(Editors, RenderSettingsAreStepsAmongEdits) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  const auto frame = [&](bool is_interacting = false) {
    update(editor, is_interacting);
    editor.record_settings(is_interacting);
  };
  const auto execute = [&](bool Commands::*command) {
    view_state_.commands.*command = true;
    frame();
  };
  const float exposure = view_state_.draw.post.exposure;
  frame();
  for (int i = 1; i <= 10; ++i) {  // a drag of a slider
    view_state_.draw.post.exposure = exposure + static_cast<float>(i);
    frame(true);
  }
  frame();
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.facts().undo, "the render settings");
  EXPECT_TRUE(editor.facts().is_saved) << "the file has none of them";
  view_state_.edits.hidden = {2};
  frame();
  view_state_.draw.shadows.method = settings::ShadowMethod::off;
  view_state_.draw.path = view_state_.paths;
  view_state_.paths.bounces = 3;
  frame();
  frame();
  ASSERT_EQ(editor.history().undo_steps(), 3u);
  execute(&Commands::undo);
  EXPECT_NE(view_state_.draw.shadows.method, settings::ShadowMethod::off);
  EXPECT_FALSE(view_state_.draw.path);
  EXPECT_NE(view_state_.paths.bounces, 3u);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{2});
  execute(&Commands::undo);
  EXPECT_TRUE(view_state_.edits.hidden.empty());
  EXPECT_EQ(view_state_.draw.post.exposure, exposure + 10);
  execute(&Commands::undo);
  EXPECT_EQ(view_state_.draw.post.exposure, exposure);
  for (int i = 0; i < 3; ++i) execute(&Commands::redo);
  EXPECT_EQ(view_state_.draw.shadows.method, settings::ShadowMethod::off);
  EXPECT_TRUE(view_state_.draw.path);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);

  // A new step ends redo, and has its own values.
  for (int i = 0; i < 3; ++i) execute(&Commands::undo);
  view_state_.draw.samples = 1;
  frame();
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  execute(&Commands::undo);
  EXPECT_EQ(view_state_.draw.samples, 4u);
  execute(&Commands::redo);
  EXPECT_EQ(view_state_.draw.samples, 1u);
  EXPECT_EQ(view_state_.draw.post.exposure, exposure);
  // What the renderer resets after undo is no step: undo would never come further.
  execute(&Commands::undo);
  view_state_.commands.redo = true;
  update(editor);
  view_state_.draw.samples = 4;
  editor.record_settings(false);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  // What another part of the program changes stays when an edit is undone.
  view_state_.edits.hidden = {1};
  frame();
  view_state_.draw.post.tone_map = settings::ToneMap::aces;
  view_state_.commands.undo = true;
  frame();
  EXPECT_EQ(view_state_.draw.post.tone_map, settings::ToneMap::aces);
  EXPECT_TRUE(view_state_.edits.hidden.empty());
}

TEST_F(Editors, RenderSettingsUndoToOldest) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  for (int i = 0; i <= 250; ++i) {
    view_state_.draw.post.exposure = static_cast<float>(1 + i);
    update(editor);
    editor.record_settings(false);
  }
  EXPECT_EQ(editor.history().undo_steps(), state::EditHistory::kMaxSteps);
  for (int i = 249; i >= 50; --i) {
    view_state_.commands.undo = true;
    update(editor);
    editor.record_settings(false);
    ASSERT_EQ(view_state_.draw.post.exposure, static_cast<float>(1 + i));
  }
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_EQ(view_state_.draw.post.exposure, 51);
}

}  // namespace
}  // namespace fire3dv::app
