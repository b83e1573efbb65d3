#include "renderer/app/stop_signals.h"

#include "base/process/stop_signals.h"

namespace fire3dv::app {

void install_stop_signals() {
  fire3dv::install_stop_signals();
}

bool stop_was_requested() {
  return stop_requested;
}

}  // namespace fire3dv::app
