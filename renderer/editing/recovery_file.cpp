#include "renderer/editing/recovery_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "base/clock.h"
#include "base/log.h"
#include "base/plural.h"
#include "renderer/editing/overlay_file.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kWriteEveryNs = 3 * kSecondNs;
constexpr int kMaxFiles = 16;  // of programs that edit the same scene at the same time, and of crashed ones

// Descriptor of the file with its lock; empty: there is none, it is another user's, or a living program's.
UniqueFd lock_file(const std::filesystem::path& path) {
  UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat status {};
  if (!fd || ::fstat(fd.get(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::geteuid() ||
      ::flock(fd.get(), LOCK_EX | LOCK_NB) != 0)
    return {};
  return fd;
}

void remove_file(const std::filesystem::path& path) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
}

}  // namespace

RecoveryFile::RecoveryFile(const std::filesystem::path& overlay, std::string scene,
                           const state::EditDocument& saved)
    : base_(overlay), scene_(std::move(scene)) {
  if (base_.empty()) return;
  if (base_.extension() == ".json") base_.replace_extension();
  for (int number = 1; number <= kMaxFiles && !found_; ++number) {
    const std::filesystem::path path = path_of(number);
    UniqueFd lock = lock_file(path);
    if (!lock) continue;
    Result<state::EditDocument> document = state::load_overlay(path);
    if (!document) {
      notes_.push_back(
          warning("unsaved edits of an earlier run cannot be read: " + document.error().message));
    } else if (*document == saved) {
      remove_file(path);
    } else {
      found_ = {path, std::move(*document)};
      found_lock_ = std::move(lock);
    }
  }
}

std::filesystem::path RecoveryFile::path_of(int number) const {
  std::filesystem::path path = base_;
  path += number == 1 ? ".recovery.json" : ".recovery-" + std::to_string(number) + ".json";
  return path;
}

state::EditDocument RecoveryFile::take_found() {
  state::EditDocument document = std::move(found_->document);
  path_ = found_->path;
  lock_ = std::move(found_lock_);
  is_written_ = true;
  written_ = document;
  found_.reset();
  return document;
}

void RecoveryFile::discard_found() {
  remove_file(found_->path);
  found_lock_ = {};
  found_.reset();
}

void RecoveryFile::choose_path() {
  for (int number = 1; number <= kMaxFiles && path_.empty(); ++number) {
    struct stat status {};
    const std::filesystem::path path = path_of(number);
    if (::lstat(path.c_str(), &status) != 0) path_ = path;
  }
}

void RecoveryFile::begin_write(const state::EditDocument& document) {
  if (path_.empty()) choose_path();
  if (path_.empty()) return;
  written_ = document;
  const auto write = [path = path_, document, scene = scene_] {
    return state::save_overlay(path, document, scene);
  };
  try {
    writing_ = std::async(std::launch::async, write);
  } catch (const std::system_error&) {  // no thread
    writing_ = std::async(std::launch::deferred, write);
  }
}

void RecoveryFile::finish_write() {
  if (!writing_.valid()) return;
  const Result<void> written = writing_.get();
  if (written) {
    is_written_ = true;
    lock_ = lock_file(path_);
  } else {
    written_.reset();
    if (!std::exchange(has_failed_, true))
      notes_.push_back(warning("unsaved edits are not protected from a crash: " + written.error().message));
  }
}

void RecoveryFile::update(const state::EditHistory& history, int64_t now_ns) {
  if (base_.empty()) return;
  if (writing_.valid() && writing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    finish_write();
  if (history.is_saved()) return remove();
  if (writing_.valid() || now_ns < next_ns_) return;
  next_ns_ = now_ns + kWriteEveryNs;
  if (written_ != history.document()) begin_write(history.document());
}

std::string RecoveryFile::keep(const state::EditHistory& history) {
  if (base_.empty() || history.is_saved()) return {};
  finish_write();
  if (written_ != history.document()) {
    begin_write(history.document());
    finish_write();
  }
  if (!is_written_ || written_ != history.document()) return {};
  return counted(history.unsaved_count(), "unsaved edit") + " stored in " + path_.string() +
         "; the next start with a window offers to apply them";
}

void RecoveryFile::remove() {
  finish_write();
  written_.reset();
  if (!std::exchange(is_written_, false)) return;
  remove_file(path_);
  lock_ = {};
  path_.clear();
}

std::vector<std::string> RecoveryFile::take_log_messages() {
  return std::exchange(notes_, {});
}

}  // namespace fire3dv::app
