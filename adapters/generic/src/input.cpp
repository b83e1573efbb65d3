// C entry points of input.h. They check arguments and convert them to scene edits; Inputs has the events.
#include "fire3dv/input.h"

#include <algorithm>
#include <climits>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "call.h"
#include "protocol/wire/check.h"
#include "scene_edits.h"
#include "stream.h"

using fire3dv::client::fail;
using fire3dv::client::guarded;
using fire3dv::client::Inputs;
using fire3dv::client::set_edit;
using fire3dv::client::text_of;
namespace wire = fire3dv::wire;

namespace {

static_assert(FIRE3DV_MAX_INPUTS == wire::kMaxInputs);
static_assert(FIRE3DV_INPUT_DRAG + 1 == wire::kInputKindCount);
static_assert(FIRE3DV_EVENT_END + 1 == wire::kInputActionCount);
static_assert(FIRE3DV_INPUT_SPEED == int{wire::kInputSpeed});
static_assert(sizeof(fire3dv_event::input) == wire::kMaxInputNameBytes + 1);
static_assert(sizeof(fire3dv_event::text) == wire::kMaxInputTextBytes + 1);

int declare_input(fire3dv_stream* stream, const char* name, const fire3dv_input* input) {
  if (!name) return fail(FIRE3DV_ERROR_ARGUMENT, "name is NULL");
  if (const char* problem = fire3dv::client::struct_error(
          input, "input is NULL", "input.struct_size is not sizeof(fire3dv_input); set it"))
    return fail(FIRE3DV_ERROR_ARGUMENT, problem);
  if (input->kind < 0 || input->kind >= static_cast<int32_t>(wire::kInputKindCount))
    return fail(FIRE3DV_ERROR_ARGUMENT,
                "input.kind is " + std::to_string(input->kind) + "; use FIRE3DV_INPUT_*");
  if (input->choice_count > wire::kMaxInputChoices)
    return fail(FIRE3DV_ERROR_ARGUMENT, "input.choice_count is " + std::to_string(input->choice_count) +
                                            "; at most 256 choices are allowed");
  if (input->choice_count != 0 && !input->choices)
    return fail(FIRE3DV_ERROR_ARGUMENT, "input.choices is NULL");
  wire::Input value;
  value.kind = static_cast<wire::InputKind>(input->kind);
  value.flags = input->flags;
  value.minimum = input->minimum;
  value.maximum = input->maximum;
  value.step = input->step;
  value.value = input->value;
  value.speed = input->speed;
  value.unit = text_of(input->unit, wire::kMaxInputUnitBytes);
  value.text = text_of(input->text, wire::kMaxInputTextBytes);
  for (size_t i = 0; i < input->choice_count; ++i) {
    if (!input->choices[i])
      return fail(FIRE3DV_ERROR_ARGUMENT, "input.choices[" + std::to_string(i) + "] is NULL");
    value.choices.push_back(text_of(input->choices[i], wire::kMaxInputNameBytes));
  }
  const std::string key = text_of(name, wire::kMaxInputNameBytes);
  if (!stream->inputs.is_declared(key) && stream->inputs.count() == wire::kMaxInputs)
    return fail(FIRE3DV_ERROR_BUDGET,
                "the stream has 256 inputs, the most that are allowed: clear others first");
  const int code = set_edit(stream, name, wire::Property::input, value);
  if (code == FIRE3DV_OK) stream->inputs.declare(key, value);
  return code;
}

int clear_input(fire3dv_stream* stream, const char* name) {
  if (!name) return fail(FIRE3DV_ERROR_ARGUMENT, "name is NULL");
  const std::string key = text_of(name, wire::kMaxInputNameBytes);
  if (!stream->inputs.is_declared(key)) return FIRE3DV_OK;
  const int code = set_edit(stream, name, wire::Property::input, wire::Cleared{});
  if (code == FIRE3DV_OK) stream->inputs.clear(key);
  return code;
}

void copy_text(const std::string& from, char* to) {
  std::memcpy(to, from.c_str(), from.size() + 1);
}

void fill(const Inputs::Taken& taken, fire3dv_event& event) {
  const wire::InputEvent& from = taken.event;
  event.kind = static_cast<int32_t>(taken.kind);
  event.action = static_cast<int32_t>(from.action);
  event.source = from.source;
  event.viewer = from.viewer;
  event.node = from.node;
  event.time_ns = from.time_ns;
  event.sim_time_ns = from.sim_time_ns;
  event.lost = taken.lost;
  event.value = from.value;
  std::copy(from.node_point.begin(), from.node_point.end(), event.node_point);
  std::copy(from.target.begin(), from.target.end(), event.target);
  copy_text(from.input, event.input);
  copy_text(from.text, event.text);
}

int poll_events(fire3dv_stream* stream, fire3dv_event* events, size_t capacity) {
  if (!events || capacity == 0) return fail(FIRE3DV_ERROR_ARGUMENT, "events is NULL, or capacity is 0");
  const size_t struct_size = events->struct_size;
  constexpr size_t kSaneSize = 4096;
  if (struct_size < sizeof *events || struct_size > kSaneSize)
    return fail(FIRE3DV_ERROR_ARGUMENT, "events[0].struct_size is " + std::to_string(struct_size) +
                                            "; set it to sizeof(fire3dv_event)");
  capacity = std::min<size_t>(capacity, INT_MAX);
  stream->read_replies();
  if (stream->inputs.has_drags())
    stream->inputs.end_lost_drags(fire3dv::client::monotonic_now_ns(), stream->link->stats().peers > 0);
  auto* to = reinterpret_cast<std::byte*>(events);
  size_t count = 0;
  for (; count < capacity; ++count, to += struct_size) {
    const std::optional<Inputs::Taken> taken = stream->inputs.take();
    if (!taken) break;
    // Other viewers, and those that join later, see the value that the program has now. Without room for it
    // they see the old one.
    if (taken->changed &&
        set_edit(stream, taken->event.input.c_str(), wire::Property::input, *taken->changed) == FIRE3DV_OK)
      stream->inputs.declare(taken->event.input, *taken->changed);
    fire3dv_event complete{};
    complete.struct_size = struct_size;
    fill(*taken, complete);
    std::memcpy(to, &complete, sizeof complete);
  }
  return static_cast<int>(count);
}

}  // namespace

int fire3dv_declare_input(fire3dv_stream* stream, const char* name, const fire3dv_input* input) {
  return guarded(stream, [&] { return declare_input(stream, name, input); });
}

int fire3dv_clear_input(fire3dv_stream* stream, const char* name) {
  return guarded(stream, [&] { return clear_input(stream, name); });
}

int fire3dv_poll_events(fire3dv_stream* stream, fire3dv_event* events, size_t capacity) {
  return guarded(stream, [&] { return poll_events(stream, events, capacity); });
}
