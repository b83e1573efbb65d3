// Golden messages of inputs and their events (protocol 1.10): valid and invalid.
#include <limits>

#include "tests/conformance/cases.h"

namespace fire3dv::conformance {
namespace {

using namespace wire;

constexpr uint64_t kInputEpoch = 0x0123456789abcdef;

SceneEdit input_case(EditValue value, std::string name = "arm/gain") {
  return {kInputEpoch, 42, std::move(name), Property::input, std::move(value)};
}

Input gain() {
  Input input;
  input.kind = InputKind::slider;
  input.minimum = -1;
  input.maximum = 2.5;
  input.step = 0.5;
  input.value = 1;
  input.unit = "N\u00b7m";
  return input;
}

Input mode() {
  Input input;
  input.kind = InputKind::choice;
  input.value = 1;
  input.choices = {"hold", "K\u00f6rper"};
  return input;
}

Input run_bar() {
  Input input;
  input.kind = InputKind::run;
  input.flags = kInputRunPause | kInputStep | kInputReset | kInputSpeed;
  input.maximum = 4;
  input.value = 1;
  input.speed = 1;
  return input;
}

Input note() {
  Input input;
  input.kind = InputKind::text;
  input.text = "K\u00f6rper";
  return input;
}

Input drag() {
  Input input;
  input.kind = InputKind::drag;
  input.value = 250;
  return input;
}

InputEvent event(InputAction action) {
  InputEvent e;
  e.epoch = kInputEpoch;
  e.source = 0xfedcba9876543210;
  e.sequence = 7;
  e.viewer = 3;
  e.time_ns = 12'345'678'901;
  e.sim_time_ns = -1'500'000'000;
  e.input = "arm/gain";
  e.action = action;
  return e;
}

InputEvent move() {
  InputEvent e = event(InputAction::move);
  e.input = "drag";
  e.node = 2;
  e.node_point = {0.1, -0.2, 0.3};
  e.target = {1, 2, -1e9};
  return e;
}

}  // namespace

std::vector<Case> input_cases() {
  InputEvent set = event(InputAction::set);
  set.value = 0.25;
  InputEvent text = event(InputAction::set);
  text.input = "note";
  text.text = "K\u00f6rper";
  Input toggle;
  toggle.kind = InputKind::toggle;
  toggle.value = 1;
  return {
      {"scene_edit-input_slider", encode(input_case(gain())), true, {}},
      {"scene_edit-input_button", encode(input_case(Input{}, "kick")), true, {}},
      {"scene_edit-input_toggle", encode(input_case(toggle, "light")), true, {}},
      {"scene_edit-input_choice", encode(input_case(mode(), "mode")), true, {}},
      {"scene_edit-input_text", encode(input_case(note(), "note")), true, {}},
      {"scene_edit-input_run", encode(input_case(run_bar(), "run")), true, {}},
      {"scene_edit-input_drag", encode(input_case(drag(), "drag")), true, {}},
      {"scene_edit-input_cleared", encode(input_case(Cleared{})), true, {}},
      {"input_event-set", encode(set), true, {}},
      {"input_event-text", encode(text), true, {}},
      {"input_event-press", encode(event(InputAction::press)), true, {}},
      {"input_event-move", encode(move()), true, {}},
  };
}

// A kind of input and an action that this version does not know.
std::vector<Case> later_input_cases() {
  Input later;
  later.kind = static_cast<InputKind>(kInputKindCount);
  return {
      {"later-scene_edit_input_kind", encode(input_case(later)), false, {}},
      {"later-input_event_action", encode(event(static_cast<InputAction>(kInputActionCount))), false, {}}};
}

std::vector<Case> refused_input_cases() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  std::vector<Case> result;
  const auto add = [&](std::string name, Input input, std::string refused, auto change) {
    change(input);
    result.push_back({"refused-scene_edit_input_" + std::move(name), encode(input_case(input)), false,
                      "SceneEdit." + std::move(refused)});
  };
  add("value_nan", gain(), "value is nan", [](Input& i) { i.value = kNan; });
  add("value_outside", gain(), "value is 3", [](Input& i) { i.value = 3; });
  add("range_empty", gain(), "maximum is -1", [](Input& i) { i.maximum = i.minimum; });
  add("range_infinite", gain(), "maximum is inf", [](Input& i) { i.maximum = kInfinite; });
  add("step_negative", gain(), "step is -1", [](Input& i) { i.step = -1; });
  add("unit_too_long", gain(), "unit has 64", [](Input& i) { i.unit = std::string(64, 'x'); });
  add("unit_escape", gain(), "unit holds a control", [](Input& i) { i.unit = "\x1b[2J"; });
  add("text_too_long", note(), "text has 1024", [](Input& i) { i.text = std::string(1024, 'x'); });
  add("choices_none", mode(), "choices is empty", [](Input& i) { i.choices.clear(); });
  add("choices_too_many", mode(), "choices holds 257",
      [](Input& i) { i.choices.assign(kMaxInputChoices + 1, "x"); });
  add("choice_repeated", mode(), "choices[1] repeats", [](Input& i) { i.choices[1] = "hold"; });
  add("choice_empty", mode(), "choices[0] is empty", [](Input& i) { i.choices[0] = ""; });
  add("choice_fraction", mode(), "value is 0.5", [](Input& i) { i.value = 0.5; });
  add("choices_of_slider", gain(), "choices is given", [](Input& i) { i.choices = {"a"}; });
  add("run_takes_nothing", run_bar(), "flags is 0", [](Input& i) { i.flags = 0; });
  add("run_half", run_bar(), "value is 0.5", [](Input& i) { i.value = 0.5; });
  add("speed_outside", run_bar(), "speed is 5", [](Input& i) { i.speed = 5; });
  add("speed_negative", run_bar(), "minimum is -1", [](Input& i) { i.minimum = -1; });
  add("toggle_two", run_bar(), "value is 2", [](Input& i) {
    i = {};
    i.kind = InputKind::toggle;
    i.value = 2;
  });
  add("stiffness_negative", drag(), "value is -1", [](Input& i) { i.value = -1; });
  result.push_back({"refused-scene_edit_input_name_empty", encode(input_case(gain(), "")), false,
                    "SceneEdit.node is empty"});
  result.push_back({"refused-scene_edit_input_name_too_long",
                    encode(input_case(gain(), std::string(128, 'x'))), false, "SceneEdit.node has 128"});
  const auto add_event = [&](std::string name, std::string refused, auto change) {
    InputEvent e = move();
    change(e);
    result.push_back(
        {"refused-input_event_" + std::move(name), encode(e), false, "InputEvent." + std::move(refused)});
  };
  add_event("epoch_zero", "epoch is 0", [](InputEvent& e) { e.epoch = 0; });
  add_event("source_zero", "source is 0", [](InputEvent& e) { e.source = 0; });
  add_event("sequence_zero", "sequence is 0", [](InputEvent& e) { e.sequence = 0; });
  add_event("input_empty", "input is empty", [](InputEvent& e) { e.input = ""; });
  add_event("input_too_long", "input has 128", [](InputEvent& e) { e.input = std::string(128, 'x'); });
  add_event("value_nan", "value is nan", [](InputEvent& e) { e.value = kNan; });
  add_event("text_too_long", "text has 1024", [](InputEvent& e) { e.text = std::string(1024, 'x'); });
  add_event("text_newline", "text holds a control", [](InputEvent& e) { e.text = "a\nb"; });
  add_event("node_too_large", "node is 1048576", [](InputEvent& e) { e.node = 1u << 20; });
  add_event("point_infinite", "node_point[1] is inf", [](InputEvent& e) { e.node_point[1] = kInfinite; });
  add_event("target_nan", "target[2] is nan", [](InputEvent& e) { e.target[2] = kNan; });
  return result;
}

}  // namespace fire3dv::conformance
