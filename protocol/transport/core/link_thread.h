// Background thread of a network link with interruptible waits: closing the link ends every wait immediately.
#pragma once

#include <sys/types.h>

#include <poll.h>
#include <sys/eventfd.h>
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "base/error.h"
#include "base/unique_fd.h"

namespace fire3dv::transport {

// Cross-thread wake-up of a poll(2) wait, without allocation.
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

// Background thread whose waits end when the link closes.
class LinkThread {
 public:
  ~LinkThread() { stop(); }

  // `name` is the link's URI, for the error.
  Result<void> start(const std::string& name, std::function<void()> body);
  // Ends the body and joins the thread. Derived links call it first in their destructors, before members are
  // destroyed.
  void stop();

  // --- any thread
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }
  void wake() noexcept { waker_.wake(); }

  // --- the body's thread
  // Readable after a wake-up: for bodies that poll many descriptors.
  int wake_fd() const { return waker_.fd(); }
  void pause(int64_t ns);
  // Waits once for `events` on `fd` (-1: none), a wake-up or the timeout; returns the events on fd.
  short wait(int fd, short events, int64_t timeout_ns);
  // Same, but continues after wake-ups. Returns false on timeout or if the link is closed.
  bool wait_for(int fd, short events, int64_t until_ns);

 private:
  Waker waker_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  pid_t owner_ = 0;
};

}  // namespace fire3dv::transport
