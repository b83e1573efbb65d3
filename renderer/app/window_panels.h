// The panels of a window: its input goes to them first, and how they are arranged is kept from run to run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "renderer/app/viewer_input.h"
#include "renderer/gui/gui.h"
#include "renderer/gui/gui_pass.h"
#include "renderer/sinks/window.h"

namespace fire3dv::app {

class WindowPanels {
 public:
  // first: as long as the program runs. Later ones take what the viewer has by now.
  WindowPanels(gpu::Device& device, gui::Viewer& viewer, bool first);
  ~WindowPanels();  // keeps the arrangement, where it is another one
  WindowPanels(const WindowPanels&) = delete;
  WindowPanels& operator=(const WindowPanels&) = delete;

  // Lays them out. What the panels want of the input does not move the view.
  ViewerInput::Owners take(sinks::Window& window, const sinks::WindowInput& input, glm::uvec2 image_px,
                           float seconds, const gui::Facts& facts, const gui::Shown& shown,
                           gui::Viewer& viewer);
  // As they were laid out last, onto the image.
  void record(gpu::Recorder& recorder, gpu::UploadBelt& belt, gpu::Image& image);

  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  std::vector<std::string> notes_;
  std::optional<std::filesystem::path> file_;
  gui::Layout kept_;
  gui::Gui gui_;
  gui::GuiPass pass_;
  sinks::Modifiers held_;
  const ImDrawData* laid_out_ = nullptr;
};

// What a window's input is for panels. held: as the last event told, which is how it stays until the next.
gui::Input panel_input(const sinks::WindowInput& input, glm::uvec2 image_px, float seconds,
                       sinks::Modifiers& held);

}  // namespace fire3dv::app
