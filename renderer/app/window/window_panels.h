// Panels of a window: input routing, layout and its persistence between runs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/window/viewer_input.h"
#include "renderer/gui/gui.h"
#include "renderer/gui/gui_pass.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

class WindowPanels {
 public:
  // first: loads the layout file, once per process. Later instances start from the viewer's state.
  WindowPanels(gpu::Device& device, gui::Viewer& viewer, bool first);
  ~WindowPanels();  // saves the layout if it changed
  WindowPanels(const WindowPanels&) = delete;
  WindowPanels& operator=(const WindowPanels&) = delete;

  // Routes input and lays out the panels. Input that the panels use does not move the view.
  ViewerInput::Owners take(sinks::Window& window, const sinks::WindowInput& input, glm::uvec2 image_px,
                           float seconds, const gui::Facts& facts, const gui::Shown& shown,
                           gui::Viewer& viewer);
  // Draws the last layout onto the image.
  void record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image);

  std::vector<std::string> take_log_messages() { return std::exchange(notes_, {}); }

 private:
  std::vector<std::string> notes_;
  std::optional<std::filesystem::path> file_;
  gui::Layout saved_;
  gui::Gui gui_;
  gui::GuiPass pass_;
  sinks::Modifiers held_;
  const ImDrawData* laid_out_ = nullptr;
};

// Converts window input to panel input. held: modifier keys of the last event, valid until the next one.
gui::Input panel_input(const sinks::WindowInput& input, glm::uvec2 image_px, float seconds,
                       sinks::Modifiers& held);

}  // namespace fire3dv::app
