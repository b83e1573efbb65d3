// Cross-thread wake-up of a poll(2) wait, without allocation.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>

#include <cstdint>

#include "protocol/base/unique_fd.h"

namespace fire3dv::transport {

class Waker {
 public:
  Waker() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}
  int fd() const { return fd_.get(); }
  explicit operator bool() const { return static_cast<bool>(fd_); }

  void wake() noexcept {
    const uint64_t one = 1;
    // A full counter rejects the write, but then the thread is awake already.
    [[maybe_unused]] const ssize_t written = ::write(fd_.get(), &one, sizeof one);
  }

  // Waits for a wake-up, for `events` on `fd` (-1: none), or for the timeout. Returns the events on fd.
  short wait(int fd, short events, int timeout_ms) {
    pollfd polled[2] = {{fd_.get(), POLLIN, 0}, {fd, events, 0}};
    if (::poll(polled, fd >= 0 ? 2 : 1, timeout_ms) <= 0) return 0;
    uint64_t count;
    if (polled[0].revents != 0) [[maybe_unused]]
      const ssize_t read = ::read(fd_.get(), &count, sizeof count);
    return fd >= 0 ? polled[1].revents : 0;
  }

 private:
  UniqueFd fd_;
};

}  // namespace fire3dv::transport
