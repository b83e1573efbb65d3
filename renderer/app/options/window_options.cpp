#include "renderer/app/options/window_options.h"

#include <CLI/CLI.hpp>
#include <cstddef>

#include "base/command_line.h"
#include "renderer/app/options/option_values.h"
#include "renderer/gui/screenshot_size.h"

namespace fire3dv::app {

int WindowTexts::chooses_cameras() const {
  return (windows->count() > 0 ? 1 : 0) + (stereo.empty() ? 0 : 1);
}

void add_window_options(CLI::App& app, Options& options, WindowTexts& texts) {
  OptionGroup group(app, "Window");
  texts.windows =
      group.add_repeatable("--window", options.window_cameras, "CAMERA", "window of this camera; repeatable");
  group.add("--stereo", texts.stereo, "LEFT,RIGHT", "two cameras side by side in one window");
  group.add_choice("--gui", texts.gui, "on|off", "panels over the image; Tab toggles them");
  group.add_choice("--theme", texts.theme, "last|dark|light",
                   "theme of the panels; last: as in the last window");
  group
      .add_choice("--present", texts.present, "vsync|mailbox|immediate",
                  "present mode: vsync, mailbox or immediate")
      ->type_name("MODE");
  group.add("--screenshot-size", texts.screenshot_size, "WxH|window",
            "of screenshots, also above the device's limit");
  texts.screenshots =
      group.add("--screenshots", options.screenshots, "DIR", "folder of screenshots and videos");
}

std::optional<std::string> take_window_options(const WindowTexts& texts, Options& options) {
  options.panels = texts.gui == "on";
  if (texts.theme != "last") options.light_panels = texts.theme == "light";
  if (texts.present == "mailbox") options.present = sinks::Present::mailbox;
  if (texts.present == "immediate") options.present = sinks::Present::immediate;
  if (texts.screenshot_size != "window") {
    const Result<glm::uvec2> size = gui::parse_screenshot_size(texts.screenshot_size);
    if (!size) return "--screenshot-size must be window or a size: " + size.error().message;
    options.screenshot_size = {ScreenshotSize::Kind::fixed, texts.screenshot_size};
  }
  constexpr size_t kMaxWindows = 16;
  if (options.window_cameras.size() > kMaxWindows)
    return "--window: " + std::to_string(kMaxWindows) + " windows at most";
  if (!options.window_cameras.empty()) options.camera = options.window_cameras.front();
  if (!texts.stereo.empty()) {
    const size_t comma = texts.stereo.find(',');
    if (comma == 0 || comma == std::string::npos || comma + 1 == texts.stereo.size())
      return "--stereo " + texts.stereo + ": must be two cameras, such as left,right";
    options.camera = texts.stereo.substr(0, comma);
    options.right_camera = texts.stereo.substr(comma + 1);
  }
  if (options.headless &&
      (!texts.stereo.empty() || texts.windows->count() > 0 || texts.screenshots->count() > 0))
    return "--window, --stereo and --screenshots need a window: leave --headless out";
  return std::nullopt;
}

}  // namespace fire3dv::app
