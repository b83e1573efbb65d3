// Test of material variants and render settings as steps of the editor.
#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

TEST_F(Editors, VariantIsAnUndoStep) {
  scene_.variants = {"day", "night"};
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  update(editor);
  viewer_.edits.variant = 0;
  update(editor);
  viewer_.edits.variant = 1;
  update(editor);
  ASSERT_EQ(editor.history().undo_steps(), 2u);
  EXPECT_EQ(editor.facts().undo, "the material variant");
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.edits.variant, 0u);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.edits.variant, scene::kNone);
  press('y');
  update(editor);
  EXPECT_EQ(viewer_.edits.variant, 0u);

  // The same variant of another scene has another number; one that is missing waits.
  scene::Scene other = scene_, less = scene_;
  other.variants = {"dusk", "night", "day"};
  less.variants = {"dusk"};
  editor.replace_scene(scene_, other, nullptr);
  EXPECT_EQ(viewer_.edits.variant, 2u);
  editor.replace_scene(other, less, nullptr);
  EXPECT_EQ(viewer_.edits.variant, scene::kNone);
  editor.update({less, names_}, false);
  EXPECT_EQ(editor.history().undo_steps(), 1u) << "a reload is no step";
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  editor.replace_scene(less, scene_, nullptr);
  EXPECT_EQ(viewer_.edits.variant, 0u);
  // Another choice takes the place of a missing one.
  editor.replace_scene(scene_, less, nullptr);
  viewer_.edits.variant = 0;
  editor.update({less, names_}, false);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("dusk"));
  press('s');
  editor.update({less, names_}, false);

  Options options;
  options.overlay = file().path;
  Result<state::EditDocument> saved = load_overlay(options);
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  gui::ViewState viewer;
  EditSession reopened(viewer, file(), *saved);
  reopened.begin(targets());
  EXPECT_EQ(viewer.edits.variant, scene::kNone);
  const std::vector<std::string> notes = reopened.take_log_messages();
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("the material variant \"dusk\" has no effect"), std::string::npos) << notes[0];
  // --variant replaces that of the file.
  options.variant = "night";
  saved = load_overlay(options);
  ASSERT_TRUE(saved.ok());
  EditSession named(viewer, file(), *saved);
  named.begin(targets());
  EXPECT_EQ(viewer.edits.variant, 1u);
  EXPECT_EQ(named.facts().undo, "");
  // It is no edit of a file.
  options.overlay.clear();
  options.scene = folder_ / "boxes.glb";
  EditSession without(viewer, overlay_file(options, true), *load_overlay(options));
  without.begin(targets());
  EXPECT_EQ(viewer.edits.variant, 1u);
  EXPECT_TRUE(without.take_log_messages().empty());
  options.overlay = folder_ / "new.json";
  EditSession missing(viewer, overlay_file(options, true), *load_overlay(options));
  missing.begin(targets());
  EXPECT_TRUE(missing.take_log_messages().empty());
}

TEST_F(Editors, RefusedVariantIsNoStep) {
  scene_.variants = {"day", "night"};
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  update(editor);
  viewer_.edits.hidden = {1};
  update(editor);
  viewer_.edits.variant = 0;
  update(editor);
  viewer_.edits.variant = 1;
  update(editor);
  const auto refuse = [&] {  // the scene stays in the variant "day"
    viewer_.edits.variant = 0;
    editor.take_shown_variant(targets());
    update(editor);
  };
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().document().at(state::variant_key()), state::EditedValue("day"));
  for (const uint32_t variant : {0u, scene::kNone}) {
    press('z');
    update(editor);
    EXPECT_EQ(viewer_.edits.variant, variant);
  }
  press('z');
  update(editor);
  EXPECT_TRUE(viewer_.edits.hidden.empty());
  EXPECT_EQ(editor.history().redo_steps(), 3u);
  for (int i = 0; i < 3; ++i) {
    press('y');
    update(editor);
  }
  EXPECT_EQ(viewer_.edits.variant, 1u) << "it is requested again";
  refuse();
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  press('z');
  update(editor);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.edits.variant, scene::kNone);
  EXPECT_EQ(viewer_.edits.hidden, (std::set<uint32_t>{1}));
}

// Edits and render settings are steps of one history; only edits are saved.
TEST_F(Editors, RenderSettingsAreStepsAmongEdits) {
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  const auto frame = [&](bool is_interacting = false) {
    update(editor, is_interacting);
    editor.record_settings(is_interacting);
  };
  const auto key = [&](char letter) {
    press(letter);
    frame();
  };
  const float exposure = viewer_.draw.post.exposure;
  frame();
  for (int i = 1; i <= 10; ++i) {  // a drag of a slider
    viewer_.draw.post.exposure = exposure + static_cast<float>(i);
    frame(true);
  }
  frame();
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.facts().undo, "the render settings");
  EXPECT_TRUE(editor.facts().is_saved) << "the file has none of them";
  viewer_.edits.hidden = {2};
  frame();
  viewer_.draw.shadows.method = settings::ShadowMethod::off;
  viewer_.draw.path = viewer_.paths;
  viewer_.paths.bounces = 3;
  frame();
  frame();
  ASSERT_EQ(editor.history().undo_steps(), 3u);
  key('z');
  EXPECT_NE(viewer_.draw.shadows.method, settings::ShadowMethod::off);
  EXPECT_FALSE(viewer_.draw.path);
  EXPECT_NE(viewer_.paths.bounces, 3u);
  EXPECT_EQ(viewer_.edits.hidden, std::set<uint32_t>{2});
  key('z');
  EXPECT_TRUE(viewer_.edits.hidden.empty());
  EXPECT_EQ(viewer_.draw.post.exposure, exposure + 10);
  key('z');
  EXPECT_EQ(viewer_.draw.post.exposure, exposure);
  for (int i = 0; i < 3; ++i) key('y');
  EXPECT_EQ(viewer_.draw.shadows.method, settings::ShadowMethod::off);
  EXPECT_TRUE(viewer_.draw.path);
  EXPECT_EQ(viewer_.edits.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.history().undo_steps(), 3u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);

  // A new step ends redo, and has its own values.
  for (int i = 0; i < 3; ++i) key('z');
  viewer_.draw.samples = 1;
  frame();
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  key('z');
  EXPECT_EQ(viewer_.draw.samples, 4u);
  key('y');
  EXPECT_EQ(viewer_.draw.samples, 1u);
  EXPECT_EQ(viewer_.draw.post.exposure, exposure);
  // What the renderer resets after undo is no step: undo would never come further.
  key('z');
  press('y');
  update(editor);
  viewer_.draw.samples = 4;
  editor.record_settings(false);
  EXPECT_EQ(editor.history().undo_steps(), 1u);
  EXPECT_EQ(editor.history().redo_steps(), 0u);
  // What another part of the program changes stays when an edit is undone.
  viewer_.edits.hidden = {1};
  frame();
  viewer_.draw.post.tone_map = settings::ToneMap::aces;
  press('z');
  frame();
  EXPECT_EQ(viewer_.draw.post.tone_map, settings::ToneMap::aces);
  EXPECT_TRUE(viewer_.edits.hidden.empty());
}

TEST_F(Editors, RenderSettingsUndoToOldest) {
  EditSession editor(viewer_, file(), {});
  editor.begin(targets());
  for (int i = 0; i <= 250; ++i) {
    viewer_.draw.post.exposure = static_cast<float>(1 + i);
    update(editor);
    editor.record_settings(false);
  }
  EXPECT_EQ(editor.history().undo_steps(), state::EditHistory::kMaxSteps);
  for (int i = 249; i >= 50; --i) {
    press('z');
    update(editor);
    editor.record_settings(false);
    ASSERT_EQ(viewer_.draw.post.exposure, static_cast<float>(1 + i));
  }
  EXPECT_EQ(editor.history().undo_steps(), 0u);
  press('z');
  update(editor);
  EXPECT_EQ(viewer_.draw.post.exposure, 51);
}

}  // namespace
}  // namespace fire3dv::app
