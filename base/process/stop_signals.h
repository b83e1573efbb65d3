// Stop request of a program by SIGINT, SIGTERM or SIGHUP, and write errors instead of deadly signals. One per
// process.
#pragma once

#include <signal.h>

#include <atomic>

namespace fire3dv {

inline std::atomic<bool> stop_requested{false};
// Called by the handler; null: nothing is.
inline std::atomic<void (*)()> after_stop_request{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<void (*)()>::is_always_lock_free,
              "a signal handler may only use what takes no lock");

// A closed pipe and a file size limit fail the write, like a full disk. Without this they end the program,
// and its files stay incomplete.
inline void ignore_write_signals() {
  for (const int number : {SIGPIPE, SIGXFSZ}) ::signal(number, SIG_IGN);
}

// Effect of a second SIGINT or SIGTERM.
enum class SecondStop { ends_program, ignored };

// From now on these signals set stop_requested. A repeated SIGHUP has no further effect: a closed terminal
// sends it from the shell and from the kernel. An ignored SIGHUP stays ignored (nohup). Also calls
// ignore_write_signals().
inline void install_stop_signals(SecondStop second = SecondStop::ends_program) {
  struct sigaction action {
  }, before{};
  action.sa_handler = [](int) {
    stop_requested = true;
    if (void (*const call)() = after_stop_request) call();
  };
  if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
    ::sigaction(SIGHUP, &action, nullptr);
  if (second == SecondStop::ends_program) action.sa_flags = static_cast<int>(SA_RESETHAND);
  for (const int number : {SIGINT, SIGTERM}) ::sigaction(number, &action, nullptr);
  ignore_write_signals();
}

}  // namespace fire3dv
