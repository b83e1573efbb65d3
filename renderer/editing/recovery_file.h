// Recovery file: copy of unsaved edits beside the overlay file, for the start after a crash, a closed
// terminal or a lost device. It is written some seconds after an edit, atomically and on a thread of its own,
// and removed when the edits are saved or discarded. A lock tells files of living programs from left ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/unique_fd.h"
#include "renderer/editing/edit_document.h"
#include "renderer/editing/edit_history.h"

namespace fire3dv::app {

class RecoveryFile {
 public:
  struct Found {
    std::filesystem::path path;
    state::EditDocument document;
  };

  // Looks for a file that an earlier run of this user left: found(). overlay: empty: there is nowhere to
  // write. scene: see OverlayFile. saved: edits of the overlay file; a file with the same ones is removed.
  RecoveryFile(const std::filesystem::path& overlay, std::string scene, const state::EditDocument& saved);
  ~RecoveryFile() = default;  // leaves the files
  RecoveryFile(const RecoveryFile&) = delete;
  RecoveryFile& operator=(const RecoveryFile&) = delete;

  const std::optional<Found>& found() const { return found_; }
  // The user has decided. take_found(): the edits are those of this run from now on; its file protects them.
  state::EditDocument take_found();
  void discard_found();

  // Writes or removes the file as the history requires. Call often.
  void update(const state::EditHistory& history, int64_t now_ns);
  // Writes the unsaved edits now, at the end of a run that nobody closed. Returns a sentence; empty: there
  // are none, or they cannot be written.
  std::string keep(const state::EditHistory& history);
  void remove();  // the edits were saved or discarded

  std::vector<std::string> take_log_messages();

 private:
  std::filesystem::path path_of(int number) const;
  void choose_path();
  void begin_write(const state::EditDocument& document);
  void finish_write();

  std::filesystem::path base_;  // the overlay's, without its ending; empty: none
  std::string scene_;
  std::optional<Found> found_;
  UniqueFd found_lock_;  // of found_: no other program offers it
  std::filesystem::path path_;
  UniqueFd lock_;  // of path_
  bool is_written_ = false, has_failed_ = false;
  std::optional<state::EditDocument> written_;
  int64_t next_ns_ = 0;
  std::vector<std::string> notes_;
  std::future<Result<void>> writing_;  // last: it blocks the destructor
};

}  // namespace fire3dv::app
