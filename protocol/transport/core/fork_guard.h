// Fork safety of links. fork() inherits open-file-description locks, so that a child would keep a dead
// parent's segment alive. The child therefore releases its copies immediately, and detects that inherited
// links are not its own.
#pragma once

#include <functional>

#include "base/unique_fd.h"

namespace fire3dv::transport {

// File descriptor that forked children release.
class UnforkableFd {
 public:
  UnforkableFd() = default;
  // Owns the descriptor that `open` returns, or nothing if it is negative. No fork() happens in between.
  // `open` must not create another UnforkableFd.
  static UnforkableFd open(const std::function<int()>& open);
  UnforkableFd(UnforkableFd&& other) noexcept;
  UnforkableFd& operator=(UnforkableFd&& other) noexcept;
  ~UnforkableFd();

  int get() const { return fd_.get(); }
  explicit operator bool() const { return static_cast<bool>(fd_); }

 private:
  UniqueFd fd_;
};

// Differs between a process and its forked children. No system call.
unsigned fork_generation();

}  // namespace fire3dv::transport
