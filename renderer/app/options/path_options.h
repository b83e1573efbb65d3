// Options of the path tracer, and of the lens.
#pragma once

#include <optional>
#include <string>

#include "renderer/app/options/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fire3dv::app {

// Values that take_path_options() converts after the whole command line is known.
struct PathTexts {
  std::string render = "raster";
  passes::PathSettings settings;
  double checkpoint_interval_s = 60;
  const CLI::Option *samples_per_pixel = nullptr, *bounces = nullptr, *seed = nullptr;
  const CLI::Option *f_number = nullptr, *focus_distance = nullptr, *checkpoint = nullptr;
};

// Both arguments outlive the parsing.
void add_path_options(CLI::App& app, PathTexts& texts);
// Sets options.path and options.lens. Returns an error message for options that need or exclude path
// tracing. options: all others are set. offline: of fire3dv render, which opens no window and ends by itself.
std::optional<std::string> take_path_options(const PathTexts& texts, bool offline, Options& options);

}  // namespace fire3dv::app
