// Options of the path tracer, and of the lens.
#pragma once

#include <optional>
#include <string>

#include "renderer/app/options/options.h"

namespace CLI {
class App;
}

namespace fire3dv::app {

// Both arguments outlive the parsing.
void add_path_options(CLI::App& app, Options& options);
// Returns an error message for options that need or exclude path tracing. app: after the parsing. options:
// all are set. offline: of fire3dv render, which opens no window and ends by itself.
std::optional<std::string> check_path_options(const CLI::App& app, bool offline, const Options& options);

}  // namespace fire3dv::app
