// Stop signals of the program: SIGINT and SIGTERM end a run in order.
#pragma once

namespace fire3dv::app {

void install_stop_signals();  // a second signal kills the process
bool stop_was_requested();

}  // namespace fire3dv::app
