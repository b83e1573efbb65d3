// Test of the recovery file of unsaved edits: when it is written and removed, who may offer it, and what the
// editor does with it.
#include "renderer/editing/recovery_file.h"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>

#include "base/unique_fd.h"
#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

class Recovery : public Editors {
 protected:
  fs::path recovery() const { return folder_ / "boxes.overlay.recovery.json"; }
  // An editor with one unsaved edit, whose file is written.
  void hide_node(EditSession& editor, uint32_t node) {
    view_state_.edits.hidden = {node};
    update(editor);
  }
  static bool says(const std::vector<std::string>& messages, std::string_view text) {
    return std::ranges::any_of(
        messages, [&](const std::string& message) { return message.find(text) != message.npos; });
  }
};

TEST_F(Recovery, UnsavedEditsAreWrittenAndRemovedWhenSaved) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  editor.offer_recovery(true);
  editor.protect_unsaved();
  EXPECT_FALSE(fs::exists(recovery())) << "there is nothing to protect";
  hide_node(editor, 2);
  while (!fs::exists(recovery())) editor.protect_unsaved();
  view_state_.commands.save_overlay = true;
  update(editor);
  editor.protect_unsaved();
  EXPECT_FALSE(fs::exists(recovery()));
}

TEST_F(Recovery, UndoneEditsAreNotKept) {
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  editor.offer_recovery(true);
  hide_node(editor, 2);
  while (!fs::exists(recovery())) editor.protect_unsaved();
  view_state_.commands.undo = true;
  update(editor);
  editor.protect_unsaved();
  EXPECT_FALSE(fs::exists(recovery()));
}

TEST_F(Recovery, RunThatNobodyClosedLeavesItsEdits) {
  {
    EditSession editor(view_state_, file(), {});
    editor.begin(targets());
    editor.offer_recovery(true);
    hide_node(editor, 2);
    EXPECT_TRUE(says(editor.end(false), "1 unsaved edit stored in " + recovery().string()));
  }
  ASSERT_TRUE(fs::exists(recovery()));
  view_state_ = {};
  EditSession headless(view_state_, file(), {});
  headless.begin(targets());
  headless.offer_recovery(false);
  EXPECT_TRUE(says(headless.take_log_messages(), "--overlay " + recovery().string()));
  EXPECT_EQ(headless.facts().recovered, "");

  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  editor.offer_recovery(true);
  EXPECT_EQ(editor.facts().recovered, "1 edit of an earlier run was not saved");
  EXPECT_TRUE(view_state_.edits.hidden.empty()) << "nobody has decided";
  view_state_.commands.recover = true;
  update(editor);
  EXPECT_EQ(view_state_.edits.hidden, std::set<uint32_t>{2});
  EXPECT_EQ(editor.facts().recovered, "");
  EXPECT_FALSE(editor.facts().is_saved);
  EXPECT_TRUE(fs::exists(recovery())) << "it protects them until they are saved";
  view_state_.commands.undo = true;
  update(editor);
  EXPECT_TRUE(view_state_.edits.hidden.empty());
  view_state_.commands.redo = true;
  view_state_.commands.save_overlay = true;
  update(editor);
  editor.protect_unsaved();
  EXPECT_FALSE(fs::exists(recovery()));
}

TEST_F(Recovery, CrashLeavesItsEdits) {
  {
    EditSession editor(view_state_, file(), {});
    editor.begin(targets());
    editor.offer_recovery(true);
    hide_node(editor, 2);
  }  // as after an exception
  EXPECT_TRUE(fs::exists(recovery()));
}

TEST_F(Recovery, DiscardedEditsLeaveNoFile) {
  {
    EditSession editor(view_state_, file(), {});
    editor.begin(targets());
    editor.offer_recovery(true);
    hide_node(editor, 2);
    while (!fs::exists(recovery())) editor.protect_unsaved();
    editor.end(true);  // the user has closed the window
  }
  EXPECT_FALSE(fs::exists(recovery()));
  {
    EditSession editor(view_state_, file(), {});
    editor.begin(targets());
    editor.offer_recovery(true);
    editor.end(false);
  }
  EXPECT_FALSE(fs::exists(recovery()));
  ASSERT_TRUE(state::save_overlay(
      recovery(), state::EditDocument{{state::variant_key(), state::VariantName("red")}}, "boxes.glb"));
  view_state_ = {};
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  editor.offer_recovery(true);
  view_state_.commands.recover = false;
  update(editor);
  EXPECT_FALSE(fs::exists(recovery()));
  EXPECT_EQ(editor.facts().recovered, "");
}

TEST_F(Recovery, FilesOfLivingProgramsAreTheirs) {
  EditSession first(view_state_, file(), {});
  first.begin(targets());
  first.offer_recovery(true);
  hide_node(first, 2);
  while (!fs::exists(recovery())) first.protect_unsaved();
  const auto is_free = [this] {
    const UniqueFd fd(::open(recovery().c_str(), O_RDONLY | O_CLOEXEC));
    return ::flock(fd.get(), LOCK_EX | LOCK_NB) == 0;
  };
  while (is_free()) first.protect_unsaved();  // the lock is taken with the first look after the write

  ViewState other;
  EditSession second(other, file(), {});
  second.begin(targets());
  second.offer_recovery(true);
  EXPECT_EQ(second.facts().recovered, "") << "it is of a program that lives";
  other.edits.hidden = {1};
  second.update(targets(), false);
  EXPECT_TRUE(says(second.end(false), "boxes.overlay.recovery-2.json"));
}

TEST_F(Recovery, DamagedFileIsNamedAndStays) {
  std::ofstream(recovery()) << "{";
  EditSession editor(view_state_, file(), {});
  editor.begin(targets());
  editor.offer_recovery(true);
  EXPECT_TRUE(says(editor.take_log_messages(), "cannot be read: " + recovery().string()));
  hide_node(editor, 1);
  EXPECT_TRUE(says(editor.end(false), "boxes.overlay.recovery-2.json"));
  EXPECT_TRUE(fs::exists(recovery()));
}

}  // namespace
}  // namespace fire3dv::app
