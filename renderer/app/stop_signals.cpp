#include "renderer/app/stop_signals.h"

#include "base/process/stop_signals.h"

#include "base/process/stop_deadline.h"

namespace fire3dv::app {

void install_stop_signals(int exit_code) {
  start_stop_deadline("fire3dv", exit_code);
  fire3dv::install_stop_signals();
}

bool stop_was_requested() {
  return stop_requested;
}

}  // namespace fire3dv::app
