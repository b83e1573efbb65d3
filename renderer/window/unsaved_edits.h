// Guard of unsaved edits: a request of the user that would discard them is refused once, with a notice.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/editing/edit_document.h"
#include "renderer/editing/edit_session.h"

namespace fire3dv::app {

class UnsavedEdits {
 public:
  explicit UnsavedEdits(const EditSession& editor) : editor_(editor) {}

  // Withdraws the notice once the edits are saved or changed, or the user continues with other work.
  void update(bool user_continues);
  // False: the request ("close", "open") is refused, and the notice says so. Repeated, it is granted.
  bool may_discard(const char* request);
  // The user opens another document, which may discard the current edits.
  void open_document();
  // Call when that document is loaded. False: later edits would be lost, as the user is told.
  bool may_replace_document();
  // may_replace_document() has refused, and still would. is_interacting: edits are being changed.
  bool holds_document(bool is_interacting) const {
    return holds_document_ && (is_interacting || !may_lose());
  }
  const std::string& notice() const { return notice_; }  // empty: none
  std::vector<std::string> take_log_messages() { return std::exchange(notes_, {}); }

 private:
  bool may_lose() const;
  void refuse(const char* request, const std::string& occasion);  // occasion: beginning of the text

  const EditSession& editor_;
  std::optional<state::EditDocument> refused_;  // edits for which a request was refused
  std::string refused_request_, notice_;
  std::optional<state::EditDocument> given_up_;  // edits that open_document() may discard
  bool holds_document_ = false;
  std::vector<std::string> notes_;
};

}  // namespace fire3dv::app
