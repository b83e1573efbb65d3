// SIGTERM and SIGHUP handlers that close the streams before AMBF ends. AMBF itself ends without unloading its
// plugins and would leave shared memory behind.
//
// The handler only wakes a thread through a pipe. The thread closes the streams, restores the previous
// handlers and raises the signal again. At most one instance per process.
#pragma once

#include <signal.h>

#include <array>
#include <functional>
#include <mutex>
#include <thread>

namespace fire3dv::ambf {

class EndSignals {
 public:
  // close is called on the internal thread, at most once.
  explicit EndSignals(std::function<void()> close);
  // Restores the previous handlers where they were not replaced meanwhile. Must not be called from close.
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
  std::mutex put_back_;  // a signal may arrive during destruction
  std::thread thread_;
};

}  // namespace fire3dv::ambf
