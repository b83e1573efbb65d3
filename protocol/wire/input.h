// Inputs: what a stream lets people do, declared by it (controls, run bar, dragging of bodies), and the
// events that a renderer sends back. SPEC section 15 is normative.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fire3dv::wire {

constexpr size_t kMaxInputs = 256;            // of one stream
constexpr uint32_t kMaxInputNameBytes = 127;  // UTF-8; also of a choice
constexpr uint32_t kMaxInputUnitBytes = 63;
constexpr uint32_t kMaxInputTextBytes = 1023;
constexpr size_t kMaxInputChoices = 256;

enum class InputKind : uint8_t {
  slider = 0,
  button = 1,
  toggle = 2,
  choice = 3,
  text = 4,
  run = 5,   // run bar: run, pause, step, reset, speed
  drag = 6,  // of a node that the stream drives, by a spring
};
constexpr size_t kInputKindCount = 7;

enum InputFlags : uint32_t {  // of InputKind::run: what it takes
  kInputRunPause = 1u << 0,
  kInputStep = 1u << 1,
  kInputReset = 1u << 2,
  kInputSpeed = 1u << 3,
};

// Declaration of an input. The key of the edit has the input's name in place of a node's.
struct Input {
  InputKind kind = InputKind::button;
  uint32_t flags = 0;               // InputFlags
  double minimum = 0, maximum = 0;  // slider; run: of its speed
  double step = 0;                  // slider: distance of its values; 0 = any
  // Current one. slider; toggle: 0 or 1; choice: index; run: 1 running, 0 paused; drag: stiffness of its
  // spring in N/m for display, 0 = unknown.
  double value = 0;
  double speed = 0;  // run: simulated seconds per second
  std::string unit;  // slider
  std::string text;  // text: its current value
  std::vector<std::string> choices;
  bool operator==(const Input&) const = default;
};

enum class InputAction : uint8_t {
  set = 0,    // slider, toggle, choice: value; text: text
  press = 1,  // button
  run = 2,
  pause = 3,
  step = 4,  // value: number of steps
  reset = 5,
  speed = 6,  // value
  begin = 7,  // drag: node, node_point, target
  move = 8,   // drag: the same
  end = 9,    // drag: node
};
constexpr size_t kInputActionCount = 10;

// Renderer to adapter: what a person did with an input.
struct InputEvent {
  uint64_t epoch = 0;       // of the stream
  uint64_t source = 0;      // random id of the renderer, not 0
  uint64_t sequence = 0;    // of this source and epoch, from 1
  uint32_t viewer = 0;      // who did it, at this source; 0 = its window
  uint64_t time_ns = 0;     // when, on the renderer's CLOCK_MONOTONIC
  int64_t sim_time_ns = 0;  // of the frame that the person saw
  std::string input;        // its name
  InputAction action = InputAction::set;
  double value = 0;
  std::string text;
  uint32_t node = 0;                   // index in StreamDescription::node_names
  std::array<double, 3> node_point{};  // grabbed point in the body's frame (that of its pose)
  std::array<double, 3> target{};      // where it is dragged to, in the stream's frame
  bool operator==(const InputEvent&) const = default;
};

// True for actions of which the newest alone counts.
constexpr bool is_continuous(InputKind kind, InputAction action) {
  return (kind == InputKind::slider && action == InputAction::set) || action == InputAction::speed ||
         action == InputAction::move;
}

// True if a declared input takes the event: the action is one of its kind, and the value in its range.
bool takes(const Input& input, const InputEvent& event);

// The value that the input has after an event that it takes, for its next declaration.
void apply(const InputEvent& event, Input& input);

}  // namespace fire3dv::wire
