// Panel of the controls and run bars that streams declare. What the user does becomes commands; the shown
// values are those that the streams have.

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

std::string_view last_part(std::string_view name) {
  return name.substr(name.rfind('/') == name.npos ? 0 : name.rfind('/') + 1);
}

std::string_view folder_of(std::string_view name) {
  return name.substr(0, name.rfind('/') == name.npos ? 0 : name.rfind('/'));
}

// A percent sign is text, not a format.
std::string slider_format(const wire::Input& input) {
  std::string unit;
  for (const char character : one_line(input.unit))
    unit += character == '%' ? "%%" : std::string(1, character);
  return unit.empty() ? "%.4g" : "%.4g " + unit;
}

class StreamControls {
 public:
  StreamControls(const Context& context, uint64_t epoch) : c_(context), epoch_(epoch) {}

  void draw(const std::string& name, const wire::Input& input, ControlsPanel::Edited& edited) const {
    const std::string label = one_line(last_part(name));
    switch (input.kind) {
      case wire::InputKind::slider:
        return draw_slider(name, label, input, input.value, wire::InputAction::set);
      case wire::InputKind::button:
        if (c_.ui.button(label.c_str())) act(name, wire::InputAction::press);
        return;
      case wire::InputKind::toggle: {
        bool value = input.value != 0;
        if (c_.ui.check(label.c_str(), value)) act(name, wire::InputAction::set, value ? 1 : 0);
        return;
      }
      case wire::InputKind::choice:
        return draw_choice(name, label, input);
      case wire::InputKind::text:
        return draw_text(name, label, input, edited);
      case wire::InputKind::run:
        return draw_run(name, input);
      case wire::InputKind::drag:
        return c_.ui.note("Ctrl-drag moves bodies by a spring");
    }
  }

 private:
  void act(const std::string& name, wire::InputAction action, double value = 0, std::string text = {}) const {
    wire::InputEvent event;
    event.input = name;
    event.action = action;
    event.value = value;
    event.text = std::move(text);
    c_.view_state.commands.inputs.push_back({epoch_, std::move(event)});
  }

  void draw_slider(const std::string& name, const std::string& label, const wire::Input& input, double now,
                   wire::InputAction action) const {
    const std::string format = slider_format(input);
    const Ui::Range range{static_cast<float>(input.minimum), static_cast<float>(input.maximum),
                          format.c_str()};
    auto value = static_cast<float>(now);
    if (!c_.ui.slider(label.c_str(), value, range)) return;
    double chosen = static_cast<double>(value);
    if (input.step > 0)
      chosen = input.minimum + input.step * std::round((chosen - input.minimum) / input.step);
    act(name, action, std::clamp(chosen, input.minimum, input.maximum));
  }

  void draw_choice(const std::string& name, const std::string& label, const wire::Input& input) const {
    std::vector<const char*> names;
    for (const std::string& choice : input.choices) names.push_back(choice.c_str());
    auto chosen = static_cast<size_t>(input.value);
    if (chosen < names.size() && c_.ui.choice(label.c_str(), chosen, names))
      act(name, wire::InputAction::set, static_cast<double>(chosen));
  }

  // Sent when the user leaves the field or presses Enter.
  void draw_text(const std::string& name, const std::string& label, const wire::Input& input,
                 ControlsPanel::Edited& edited) const {
    const bool is_edited = edited.epoch == epoch_ && edited.name == name;
    std::string value = is_edited ? edited.text : input.text;
    c_.ui.note(label);
    if (c_.ui.text(label.c_str(), "", value)) edited = {epoch_, name, value};
    if (!ImGui::IsItemDeactivatedAfterEdit()) return;
    act(name, wire::InputAction::set, 0, printable_text(value, wire::kMaxInputTextBytes));
    edited = {};
  }

  void draw_run(const std::string& name, const wire::Input& input) const {
    const bool is_running = input.value == 1;
    bool follows = false;
    const auto button = [&](wire::InputFlags flag, const char* label, wire::InputAction action) {
      if ((input.flags & flag) == 0) return;
      if (follows) c_.ui.same_line();
      follows = true;
      if (c_.ui.button(label)) act(name, action, 1);
    };
    button(wire::kInputRunPause, is_running ? "Pause" : "Run",
           is_running ? wire::InputAction::pause : wire::InputAction::run);
    button(wire::kInputStep, "Step", wire::InputAction::step);
    button(wire::kInputReset, "Reset", wire::InputAction::reset);
    if (input.flags & wire::kInputSpeed)
      draw_slider(name, "Speed", input, input.speed, wire::InputAction::speed);
  }

  const Context& c_;
  const uint64_t epoch_;
};

}  // namespace

void ControlsPanel::draw(const Context& c) {
  if (c.shown.controlled_streams.empty()) return;
  if (!c.ui.header("Controls", c.layout.is_open(Panel::controls))) return;
  for (const state::StreamId id : c.shown.controlled_streams) {
    const state::Stream& stream = c.shown.poses.streams()[id];
    if (c.shown.controlled_streams.size() > 1) c.ui.note(one_line(stream.name));
    std::string folder;
    ImGui::PushID(static_cast<int>(id));
    for (const auto& [name, entry] : stream.inputs().inputs()) {
      if (folder_of(name) != folder) {
        folder = folder_of(name);
        c.ui.note(folder.empty() ? "Other" : one_line(folder));
      }
      ImGui::PushID(name.c_str());
      StreamControls(c, stream.epoch).draw(name, entry.input, edited_);
      ImGui::PopID();
    }
    ImGui::PopID();
  }
}

}  // namespace fire3dv::gui
