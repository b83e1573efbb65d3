#include "renderer/app/stop_signals.h"

#include <csignal>

namespace fire3dv::app {
namespace {

volatile std::sig_atomic_t stop_requested = 0;

}  // namespace

void install_stop_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_requested = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool stop_was_requested() {
  return stop_requested != 0;
}

}  // namespace fire3dv::app
