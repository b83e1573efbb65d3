// AMBF does not hear SIGTERM: it would end without closing its plugins, and shared memory would stay behind.
// Here SIGTERM and SIGHUP close the streams first and then do what they would have done: call the handler
// that was there, or end the process. A handler may do next to nothing, so it wakes a thread that does the
// rest. One at a time in a process.
#pragma once

#include <signal.h>

#include <array>
#include <functional>
#include <mutex>
#include <thread>

namespace fire3dv::ambf {

class EndSignals {
 public:
  // close is called on a thread of its own, at most once.
  explicit EndSignals(std::function<void()> close);
  // Puts back what was there, where it is still ours to put back. Not from within close.
  ~EndSignals();
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;

  static constexpr std::array kSignals{SIGTERM, SIGHUP};

 private:
  void wait_for_signal();
  void put_back();

  std::function<void()> close_;
  int read_fd_ = -1;
  std::array<struct sigaction, kSignals.size()> before_{};
  std::array<bool, kSignals.size()> ours_{};
  std::mutex put_back_;  // a signal may come while this ends
  std::thread thread_;
};

}  // namespace fire3dv::ambf
