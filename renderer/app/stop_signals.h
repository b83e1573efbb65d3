// Stop signals of the program: SIGINT, SIGTERM and SIGHUP end a run in order.
#pragma once

namespace fire3dv::app {

void install_stop_signals();  // a second SIGINT or SIGTERM kills the process
bool stop_was_requested();

}  // namespace fire3dv::app
