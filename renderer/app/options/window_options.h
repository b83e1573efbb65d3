// Options of the window: cameras, panels, presentation and screenshots.
#pragma once

#include <optional>
#include <string>

#include "renderer/app/options/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fire3dv::app {

// Values that take_window_options() converts after the whole command line is known.
struct WindowTexts {
  std::string stereo, gui = "on", present = "vsync", theme = "last", screenshot_size = "window";
  const CLI::Option *windows = nullptr, *screenshots = nullptr;

  // Number of options that choose the cameras of windows: --window and --stereo.
  int chooses_cameras() const;
};

// Both arguments outlive the parsing.
void add_window_options(CLI::App& app, Options& options, WindowTexts& texts);
// Returns an error message for invalid values. options: those of all programs are set.
std::optional<std::string> take_window_options(const WindowTexts& texts, Options& options);

}  // namespace fire3dv::app
