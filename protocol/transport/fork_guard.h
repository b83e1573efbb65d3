// Locks of the open-file-description kind are inherited by fork: a child that lives on would keep its dead
// parent's segment alive. So the child gives its copies back at once, and knows that the links it inherited
// are not its own.
#pragma once

#include <functional>

#include "protocol/transport/unique_fd.h"

namespace fire3dv::transport {

// A descriptor that a forked child does not keep.
class UnforkableFd {
 public:
  UnforkableFd() = default;
  // Owns the descriptor that `open` returns, or nothing when that is negative. No fork happens between the
  // two. `open` must not make another one.
  static UnforkableFd open(const std::function<int()>& open);
  UnforkableFd(UnforkableFd&& other) noexcept;
  UnforkableFd& operator=(UnforkableFd&& other) noexcept;
  ~UnforkableFd();

  int get() const { return fd_.get(); }
  explicit operator bool() const { return static_cast<bool>(fd_); }

 private:
  UniqueFd fd_;
};

// Differs between a process and the children that it forks. Costs no system call.
unsigned fork_generation();

}  // namespace fire3dv::transport
