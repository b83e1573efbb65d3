// Stop request of a program by SIGINT, SIGTERM or SIGHUP. One per process.
#pragma once

#include <signal.h>

#include <atomic>
#include <initializer_list>

namespace fire3dv {

inline std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only use what takes no lock");

// From now on the first of these signals sets stop_requested; a second one ends the program immediately.
inline void install_stop_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaction(number, &action, nullptr);
}

}  // namespace fire3dv
