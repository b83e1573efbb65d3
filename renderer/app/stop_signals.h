// Stop signals of the program: SIGINT, SIGTERM and SIGHUP end a run in order, and at the deadline of
// stop_deadline.h.
#pragma once

namespace fire3dv::app {

// exit_code: of a run that ends at the deadline. A second SIGINT or SIGTERM kills the process.
void install_stop_signals(int exit_code);
bool stop_was_requested();

}  // namespace fire3dv::app
