#include "renderer/window/unsaved_edits.h"

#include "base/log.h"
#include "base/plural.h"

namespace fire3dv::app {

void UnsavedEdits::update(bool user_continues) {
  const state::EditHistory& history = editor_.history();
  if (!refused_ || (!user_continues && !history.is_saved() && *refused_ == history.document())) return;
  refused_.reset();
  notice_.clear();
}

bool UnsavedEdits::may_discard(const char* request) {
  const state::EditHistory& history = editor_.history();
  if (history.is_saved() || (refused_ == history.document() && refused_request_ == request)) return true;
  refuse(request, "");
  return false;
}

void UnsavedEdits::open_document() {
  holds_document_ = false;
  given_up_.reset();
  if (!editor_.history().is_saved()) given_up_ = editor_.history().document();
}

bool UnsavedEdits::may_replace_document() {
  if (may_lose()) return true;
  if (!std::exchange(holds_document_, true)) refuse("open", "the opened file is loaded, but ");
  return false;
}

bool UnsavedEdits::may_lose() const {
  const state::EditHistory& history = editor_.history();
  return history.is_saved() || given_up_ == history.document();
}

void UnsavedEdits::refuse(const char* request, const std::string& occasion) {
  const state::EditHistory& history = editor_.history();
  refused_ = history.document();
  refused_request_ = request;
  const size_t count = history.unsaved_count();
  const bool is_one = count == 1;
  notice_ =
      occasion + counted(count, "edit") + (is_one ? " is" : " are") + " not saved: " +
      (editor_.facts().file.empty() ? "a recording's scene needs --overlay FILE to save" : "Ctrl+S saves") +
      (is_one ? " it; " : " them; ") + request + " again to discard " + (is_one ? "it" : "them");
  notes_.push_back(warning(notice_));
}

}  // namespace fire3dv::app
