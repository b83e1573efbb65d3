// Test of the guard of unsaved edits.
#include "renderer/window/unsaved_edits.h"

#include <optional>

#include "tests/unit/renderer/editing/editor_fixture.h"

namespace fire3dv::app {
namespace {

class UnsavedEditsTest : public Editors {
 protected:
  void SetUp() override {
    Editors::SetUp();
    editor_.emplace(view_state_, file(), state::EditDocument());
    editor_->begin(targets());
    update(*editor_);
    unsaved_.emplace(*editor_);
  }
  void hide(uint32_t node) {
    view_state_.edits.hidden.insert(node);
    update(*editor_);
  }

  std::optional<EditSession> editor_;
  std::optional<UnsavedEdits> unsaved_;
};

TEST_F(UnsavedEditsTest, RepeatedRequestDiscards) {
  EXPECT_TRUE(unsaved_->may_discard("close")) << "nothing is edited";
  hide(1);
  EXPECT_FALSE(unsaved_->may_discard("close"));
  EXPECT_EQ(unsaved_->notice(), "1 edit is not saved: Ctrl+S saves it; close again to discard it");
  EXPECT_EQ(unsaved_->take_log_messages().size(), 1u);
  EXPECT_FALSE(unsaved_->may_discard("open")) << "another request";
  EXPECT_TRUE(unsaved_->may_discard("open"));
}

TEST_F(UnsavedEditsTest, NoticeEndsWithNextEditOrClick) {
  hide(1);
  EXPECT_FALSE(unsaved_->may_discard("close"));
  unsaved_->update(false);
  EXPECT_NE(unsaved_->notice(), "");
  hide(2);
  unsaved_->update(false);
  EXPECT_EQ(unsaved_->notice(), "");
  EXPECT_FALSE(unsaved_->may_discard("close"));
  unsaved_->update(true);
  EXPECT_EQ(unsaved_->notice(), "");
  EXPECT_FALSE(unsaved_->may_discard("close"));
}

TEST_F(UnsavedEditsTest, LoadedDocumentWaitsForNewerEdits) {
  hide(1);
  unsaved_->open_document();
  EXPECT_TRUE(unsaved_->may_replace_document()) << "the user gave these edits up";
  hide(2);
  EXPECT_FALSE(unsaved_->holds_document(false));
  EXPECT_FALSE(unsaved_->may_replace_document());
  EXPECT_TRUE(unsaved_->holds_document(false));
  EXPECT_NE(unsaved_->notice().find("the opened file is loaded, but 2 edits are not saved"),
            std::string::npos);
  unsaved_->open_document();
  EXPECT_TRUE(unsaved_->may_replace_document());
}

}  // namespace
}  // namespace fire3dv::app
