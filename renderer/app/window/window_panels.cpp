#include "renderer/app/window/window_panels.h"

#include <cstdlib>
#include <utility>

#include "renderer/app/start.h"

namespace fire3dv::app {
namespace {

gui::Key panel_key(sinks::Key key) {
  constexpr std::pair<sinks::Key, gui::Key> kKeys[] = {{sinks::Key::tab, gui::Key::tab},
                                                       {sinks::Key::left, gui::Key::left},
                                                       {sinks::Key::right, gui::Key::right},
                                                       {sinks::Key::up, gui::Key::up},
                                                       {sinks::Key::down, gui::Key::down},
                                                       {sinks::Key::page_up, gui::Key::page_up},
                                                       {sinks::Key::page_down, gui::Key::page_down},
                                                       {sinks::Key::home, gui::Key::home},
                                                       {sinks::Key::end, gui::Key::end},
                                                       {sinks::Key::insert, gui::Key::insert},
                                                       {sinks::Key::remove, gui::Key::del},
                                                       {sinks::Key::backspace, gui::Key::backspace},
                                                       {sinks::Key::space, gui::Key::space},
                                                       {sinks::Key::enter, gui::Key::enter},
                                                       {sinks::Key::escape, gui::Key::escape},
                                                       {sinks::letter('a'), gui::Key::a},
                                                       {sinks::letter('c'), gui::Key::c},
                                                       {sinks::letter('v'), gui::Key::v},
                                                       {sinks::letter('x'), gui::Key::x},
                                                       {sinks::letter('y'), gui::Key::y},
                                                       {sinks::letter('z'), gui::Key::z}};
  for (const auto& [theirs, ours] : kKeys) {
    if (theirs == key) return ours;
  }
  return gui::Key::none;
}

std::optional<std::filesystem::path> layout_path() {
  return gui::layout_place([](const char* name) { return std::getenv(name); });
}

gui::Layout load(const std::optional<std::filesystem::path>& file, std::vector<std::string>& notes) {
  if (!file) return {};
  Result<gui::Layout> layout = gui::load_layout(*file);
  if (layout) return *layout;
  notes.push_back(layout.error().message);
  return {};
}

}  // namespace

gui::Input panel_input(const sinks::WindowInput& input, glm::uvec2 image_px, float seconds,
                       sinks::Modifiers& held) {
  using Kind = sinks::InputEvent::Kind;
  gui::Input panel;
  panel.display_px = glm::vec2(image_px);
  panel.scale = input.scale;
  panel.delta_s = seconds;
  for (const sinks::InputEvent& event : input.events) {
    held = event.modifiers;
    switch (event.kind) {
      case Kind::move:
        panel.events.emplace_back(gui::MouseMoved{event.cursor_px});
        break;
      case Kind::button:
        panel.events.emplace_back(gui::MouseMoved{event.cursor_px});
        panel.events.emplace_back(gui::MouseButton{static_cast<gui::Button>(event.button), event.down});
        break;
      case Kind::wheel:
        panel.events.emplace_back(gui::MouseWheel{event.wheel});
        break;
      case Kind::key:
        if (const gui::Key key = panel_key(event.key); key != gui::Key::none)
          panel.events.emplace_back(gui::KeyChanged{key, event.down});
        break;
      case Kind::text:
        panel.events.emplace_back(gui::Text{event.text});
        break;
      case Kind::leave:
        panel.events.emplace_back(gui::MouseLeft{});
        break;
      case Kind::focus:
        break;
    }
  }
  panel.ctrl = held.control;
  panel.shift = held.shift;
  panel.alt = held.alt;
  return panel;
}

WindowPanels::WindowPanels(gpu::Device& device, gui::Viewer& viewer, bool first)
    : file_(layout_path()),
      saved_(load(file_, notes_)),
      gui_(saved_, {sinks::Window::clipboard, sinks::Window::set_clipboard}),
      pass_(device) {
  if (first) viewer.camera_speed = saved_.camera_speed;
}

WindowPanels::~WindowPanels() {
  if (!file_ || gui_.layout() == saved_) return;
  if (Result<void> saved = gui::save_layout(*file_, gui_.layout()); !saved) say(saved.error().message);
}

ViewerInput::Owners WindowPanels::take(sinks::Window& window, const sinks::WindowInput& input,
                                       glm::uvec2 image_px, float seconds, const gui::Facts& facts,
                                       const gui::Shown& shown, gui::Viewer& viewer) {
  laid_out_ = &gui_.frame(panel_input(input, image_px, seconds, held_), facts, shown, viewer);
  window.set_cursor(static_cast<sinks::Window::Cursor>(gui_.cursor()));
  return {!gui_.wants_mouse(), !gui_.wants_keyboard()};
}

void WindowPanels::record(gpu::Recorder& recorder, gpu::StagingRing& staging, gpu::Image& image) {
  if (laid_out_) pass_.record(recorder, staging, image, *laid_out_, gui_.fonts(), gui_.fonts_number());
}

}  // namespace fire3dv::app
