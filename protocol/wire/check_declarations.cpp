// Validation of what streams declare: scalars and their values, inputs and their events.
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "protocol/wire/check.h"

namespace fire3dv::wire {
Result<void> check(const Scalars& scalars, const DecodeLimits& limits) {
  const size_t count = scalars.names.size();
  if (count == 0) return Error{"SceneEdit.names is empty; clear the group of scalars instead"};
  if (count > kMaxScalars)
    return Error{"SceneEdit.names holds " + std::to_string(count) + " names; at most " +
                 std::to_string(kMaxScalars) + " scalars are allowed"};
  if (scalars.units.size() != count)
    return Error{"SceneEdit.units holds " + std::to_string(scalars.units.size()) + " units for " +
                 std::to_string(count) + " names; one for each name is needed, empty where there is none"};
  for (size_t i = 0; i < count; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    if (scalars.names[i].empty()) return Error{"SceneEdit.names" + index + " is empty; a scalar has a name"};
    if (auto good = check_text("SceneEdit.names" + index, scalars.names[i], limits.max_name_bytes); !good)
      return good;
    if (auto good = check_text("SceneEdit.units" + index, scalars.units[i], kMaxScalarUnitBytes); !good)
      return good;
  }
  return check_unique("SceneEdit.names", scalars.names);
}

Result<void> check(const ScalarValues& scalars) {
  if (scalars.declaration == 0)
    return Error{"SceneEdit.declaration is 0; it is the version of the edit that declared the group"};
  if (scalars.values.empty()) return Error{"SceneEdit.values is empty; a group has at least one scalar"};
  if (scalars.values.size() > kMaxScalars)
    return Error{"SceneEdit.values holds " + std::to_string(scalars.values.size()) + " values; at most " +
                 std::to_string(kMaxScalars) + " scalars are allowed"};
  return {};
}

namespace {

constexpr double kMaxInputValue = 1e12;

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

// NaN is not within any bound.
Result<void> check_magnitude(const std::string& field, double value) {
  if (std::fabs(value) <= kMaxInputValue) return {};
  return Error{field + " is " + number_text(value) + "; finite numbers of magnitude up to 1e+12 are allowed"};
}

Result<void> check_between(const std::string& field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return Error{field + " is " + number_text(value) + "; it must lie in " + number_text(low) + " to " +
               number_text(high)};
}

Result<void> check_numbers(const Input& input) {
  const std::pair<const char*, double> numbers[] = {{"SceneEdit.minimum", input.minimum},
                                                    {"SceneEdit.maximum", input.maximum},
                                                    {"SceneEdit.step", input.step},
                                                    {"SceneEdit.value", input.value},
                                                    {"SceneEdit.speed", input.speed}};
  for (const auto& [field, number] : numbers)
    if (auto good = check_magnitude(field, number); !good) return good;
  return {};
}

Result<void> check_choices(const Input& input) {
  if (input.kind != InputKind::choice) {
    if (input.choices.empty()) return {};
    return Error{"SceneEdit.choices is given; an input of another kind than choice has none"};
  }
  if (input.choices.empty()) return Error{"SceneEdit.choices is empty; a choice has at least one text"};
  if (input.choices.size() > kMaxInputChoices)
    return Error{"SceneEdit.choices holds " + std::to_string(input.choices.size()) + " texts; at most " +
                 std::to_string(kMaxInputChoices) + " are allowed"};
  for (size_t i = 0; i < input.choices.size(); ++i) {
    const std::string field = "SceneEdit.choices[" + std::to_string(i) + "]";
    if (input.choices[i].empty()) return Error{field + " is empty; a choice has a text"};
    if (auto good = check_text(field, input.choices[i], kMaxInputNameBytes); !good) return good;
  }
  if (auto good = check_unique("SceneEdit.choices", input.choices); !good) return good;
  const auto last = static_cast<double>(input.choices.size() - 1);
  if (auto good = check_between("SceneEdit.value", input.value, 0, last); !good) return good;
  if (input.value != std::floor(input.value))
    return Error{"SceneEdit.value is " + number_text(input.value) + "; of a choice it is an index"};
  return {};
}

Result<void> check_range(const Input& input, const char* field, double value) {
  if (!(input.minimum < input.maximum))
    return Error{"SceneEdit.maximum is " + number_text(input.maximum) + "; it must be more than minimum (" +
                 number_text(input.minimum) + ")"};
  return check_between(field, value, input.minimum, input.maximum);
}

Result<void> check_run(const Input& input) {
  constexpr uint32_t kKnown = kInputRunPause | kInputStep | kInputReset | kInputSpeed;
  if ((input.flags & kKnown) == 0)
    return Error{"SceneEdit.flags is " + std::to_string(input.flags) +
                 "; a run bar takes at least one of run and pause (1), step (2), reset (4), speed (8)"};
  if (input.value != 0 && input.value != 1)
    return Error{"SceneEdit.value is " + number_text(input.value) +
                 "; of a run bar it is 1 (running) or 0 (paused)"};
  if ((input.flags & kInputSpeed) == 0) return {};
  if (input.minimum < 0)
    return Error{"SceneEdit.minimum is " + number_text(input.minimum) + "; a speed is not negative"};
  return check_range(input, "SceneEdit.speed", input.speed);
}

}  // namespace

Result<void> check(const Input& input) {
  if (static_cast<size_t>(input.kind) >= kInputKindCount)
    return Error{"SceneEdit.kind is " + std::to_string(static_cast<int>(input.kind)) +
                 "; inputs are of kind 0 to " + std::to_string(kInputKindCount - 1)};
  if (auto good = check_numbers(input); !good) return good;
  if (auto good = check_text("SceneEdit.unit", input.unit, kMaxInputUnitBytes); !good) return good;
  if (auto good = check_text("SceneEdit.text", input.text, kMaxInputTextBytes); !good) return good;
  if (auto good = check_choices(input); !good) return good;
  switch (input.kind) {
    case InputKind::slider:
      if (input.step < 0)
        return Error{"SceneEdit.step is " + number_text(input.step) + "; it must be 0 (any value) or more"};
      return check_range(input, "SceneEdit.value", input.value);
    case InputKind::toggle:
      if (input.value == 0 || input.value == 1) return {};
      return Error{"SceneEdit.value is " + number_text(input.value) + "; of a toggle it is 0 or 1"};
    case InputKind::run:
      return check_run(input);
    case InputKind::drag:
      if (input.value >= 0) return {};
      return Error{"SceneEdit.value is " + number_text(input.value) +
                   "; of a drag it is a stiffness in N/m, or 0 (unknown)"};
    case InputKind::button:
    case InputKind::choice:
    case InputKind::text:
      return {};
  }
  return {};
}

Result<void> check(const InputEvent& event, const DecodeLimits& limits) {
  if (event.epoch == 0) return Error{"InputEvent.epoch is 0; an epoch is a random number that is not 0"};
  if (event.source == 0) return Error{"InputEvent.source is 0; it is a random number that is not 0"};
  if (event.sequence == 0) return Error{"InputEvent.sequence is 0; sequences start at 1"};
  if (event.input.empty()) return Error{"InputEvent.input is empty; it is the input's name"};
  if (auto good = check_text("InputEvent.input", event.input, kMaxInputNameBytes); !good) return good;
  if (static_cast<size_t>(event.action) >= kInputActionCount)
    return Error{"InputEvent.action is " + std::to_string(static_cast<int>(event.action)) +
                 "; actions are 0 to " + std::to_string(kInputActionCount - 1)};
  if (auto good = check_magnitude("InputEvent.value", event.value); !good) return good;
  if (auto good = check_text("InputEvent.text", event.text, kMaxInputTextBytes); !good) return good;
  if (event.node >= limits.max_nodes)
    return Error{"InputEvent.node is " + std::to_string(event.node) + "; a stream has at most " +
                 std::to_string(limits.max_nodes) + " nodes"};
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string index = "[" + std::to_string(axis) + "]";
    if (auto good = check_magnitude("InputEvent.node_point" + index, event.node_point[axis]); !good)
      return good;
    if (auto good = check_magnitude("InputEvent.target" + index, event.target[axis]); !good) return good;
  }
  return {};
}

bool takes(const Input& input, const InputEvent& event) {
  const auto in_range = [&] { return event.value >= input.minimum && event.value <= input.maximum; };
  const auto is_of_run = [&](InputFlags flag) {
    return input.kind == InputKind::run && (input.flags & flag) != 0;
  };
  constexpr double kMaxSteps = 1e6;
  switch (event.action) {
    case InputAction::set:
      if (input.kind == InputKind::slider) return in_range();
      if (input.kind == InputKind::toggle) return event.value == 0 || event.value == 1;
      if (input.kind == InputKind::choice)
        return event.value >= 0 && event.value < static_cast<double>(input.choices.size()) &&
               event.value == std::floor(event.value);
      return input.kind == InputKind::text;
    case InputAction::press:
      return input.kind == InputKind::button;
    case InputAction::run:
    case InputAction::pause:
      return is_of_run(kInputRunPause);
    case InputAction::step:
      return is_of_run(kInputStep) && event.value >= 1 && event.value <= kMaxSteps &&
             event.value == std::floor(event.value);
    case InputAction::reset:
      return is_of_run(kInputReset);
    case InputAction::speed:
      return is_of_run(kInputSpeed) && in_range();
    case InputAction::begin:
    case InputAction::move:
    case InputAction::end:
      return input.kind == InputKind::drag;
  }
  return false;
}

void apply(const InputEvent& event, Input& input) {
  if (event.action == InputAction::set && input.kind == InputKind::text)
    input.text = event.text;
  else if (event.action == InputAction::set)
    input.value = event.value;
  if (event.action == InputAction::run) input.value = 1;
  if (event.action == InputAction::pause) input.value = 0;
  if (event.action == InputAction::speed) input.speed = event.value;
}

}  // namespace fire3dv::wire
