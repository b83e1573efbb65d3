// Background thread of a network link with interruptible waits: closing the link ends every wait immediately.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "protocol/base/error.h"
#include "protocol/transport/core/waker.h"

namespace fire3dv::transport {

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
