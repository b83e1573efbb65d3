// The one thread that a network link has of its own, and the ways in which it may wait: all of them end at
// once when the link is closed.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <string>
#include <thread>

#include "protocol/error.h"
#include "protocol/transport/waker.h"

namespace fire3dv::transport {

class LinkThread {
 public:
  ~LinkThread() { stop(); }

  // `name` is the link's URI, for the error.
  Result<void> start(const std::string& name, std::function<void()> body);
  // Ends the body and waits for that. A derived link calls it first in its destructor, while its members
  // still stand.
  void stop();

  // --- any thread
  bool stopping() const { return stop_.load(std::memory_order_relaxed); }
  void wake() noexcept { waker_.wake(); }

  // --- the body's thread
  // For a body with many descriptors to wait for: readable when it was woken.
  int wake_fd() const { return waker_.fd(); }
  void pause(int64_t ns);
  // One wait for `events` on `fd` (-1: none), a wake-up or the time; returns what came on fd.
  short wait(int fd, short events, int64_t timeout_ns);
  // Waits through wake-ups. False when the time is over or the link is closed.
  bool wait_for(int fd, short events, int64_t until_ns);

 private:
  Waker waker_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  pid_t owner_ = 0;
};

}  // namespace fire3dv::transport
