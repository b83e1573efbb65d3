#include "renderer/streams/input_router.h"

#include <algorithm>
#include <utility>

#include "base/random.h"
#include "protocol/wire/check.h"

namespace fire3dv::app {

using wire::InputAction;

InputRouter::InputRouter(const state::PoseState& poses, Link link)
    : poses_(poses), link_(std::move(link)), source_(random_id()) {}

const state::Stream* InputRouter::find(uint64_t epoch) const {
  const auto is_named = [epoch](const state::Stream& stream) {
    return stream.active && stream.epoch == epoch;
  };
  const auto found = std::ranges::find_if(poses_.streams(), is_named);
  return found == poses_.streams().end() || !link_.carries_input(epoch) ? nullptr : &*found;
}

std::vector<state::StreamId> InputRouter::streams() const {
  std::vector<state::StreamId> listed;
  for (size_t id = 0; id < poses_.streams().size(); ++id) {
    const state::Stream& stream = poses_.streams()[id];
    if (stream.active && !stream.inputs().inputs().empty() && link_.carries_input(stream.epoch))
      listed.push_back(static_cast<state::StreamId>(id));
  }
  return listed;
}

uint64_t InputRouter::revision() const {
  uint64_t revision = 0;
  for (const state::StreamId id : streams())
    revision = 31 * revision + poses_.streams()[id].epoch + poses_.streams()[id].inputs().revision();
  return revision;
}

// A stream that comes back after a lost connection keeps its epoch, and its receiver the last sequence: the
// numbers must go on. Those of the epochs that are forgotten are below the ones of any later epoch.
InputRouter::StreamState& InputRouter::state_of(uint64_t epoch) {
  const auto known = streams_.find(epoch);
  if (known != streams_.end()) return known->second;
  const auto has_ended = [&](const auto& entry) { return !find(entry.first); };
  while (streams_.size() >= kMaxEpochs) {
    const auto ended = std::ranges::find_if(streams_, has_ended);
    if (ended == streams_.end()) break;
    forgotten_sequence_ = std::max(forgotten_sequence_, ended->second.sequence);
    streams_.erase(ended);
  }
  return streams_.emplace(epoch, StreamState{forgotten_sequence_, {}}).first->second;
}

void InputRouter::send(uint64_t epoch, wire::InputEvent event, int64_t now_ns) {
  const state::Stream* const stream = find(epoch);
  if (!stream) return;
  event.epoch = epoch;
  event.source = source_;
  event.sequence = ++state_of(epoch).sequence;
  if (event.time_ns == 0) event.time_ns = static_cast<uint64_t>(now_ns);
  event.sim_time_ns = stream->header.sim_time_ns;
  ++sent_;
  link_.send(epoch, event);
}

void InputRouter::flush(const Key& key, int64_t now_ns) {
  const auto waiting = pending_.find(key);
  if (waiting == pending_.end()) return;
  send(std::get<0>(key), std::move(waiting->second), now_ns);
  sent_ns_[key] = now_ns;
  pending_.erase(waiting);
}

// Returns false for an event without effect: a second begin, or a move or end of what the viewer does not
// hold.
bool InputRouter::begin_or_end(const Key& key, const wire::InputEvent& event) {
  const auto held = holds_.find(key);
  if (event.action == InputAction::begin) return held == holds_.end() && holds_.emplace(key, event).second;
  if (held == holds_.end() || held->second.node != event.node) return false;
  if (event.action == InputAction::end)
    holds_.erase(held);
  else
    held->second = event;
  return true;
}

bool InputRouter::act(uint64_t epoch, InputViewer viewer, wire::InputEvent event) {
  const state::Stream* const stream = find(epoch);
  const wire::Input* const input = stream ? stream->inputs().find(event.input) : nullptr;
  if (!input) return drop();
  const int64_t now_ns = link_.now_ns();
  event.epoch = epoch;
  event.source = source_;
  event.sequence = 1;  // send() counts
  event.viewer = viewer;
  event.time_ns = static_cast<uint64_t>(now_ns);
  Key key(epoch, viewer, event.input);
  // What is held can be released, even if its input was declared again as another kind meanwhile.
  const bool ends_hold = event.action == InputAction::end && holds_.contains(key);
  if (!ends_hold && !takes(*input, event)) return drop();
  if (!wire::check(event, {})) return drop();
  const bool is_drag = event.action >= InputAction::begin;
  if (is_drag && event.node >= stream->scene_node_of_pose.size()) return drop();
  const bool is_newest_only = is_continuous(input->kind, event.action);
  // The end of a drag is never refused.
  if (!is_newest_only && event.action != InputAction::end &&
      !state_of(epoch).limit.take(now_ns, kEventsPerSecond))
    return drop();
  if (is_drag && !begin_or_end(key, event)) return drop();
  if (is_newest_only) {
    pending_[key] = std::move(event);
    if (now_ns - sent_ns_[key] >= kSendPeriodNs) flush(key, now_ns);
    return true;
  }
  flush(key, now_ns);  // what was done before comes before
  send(epoch, std::move(event), now_ns);
  if (is_drag) sent_ns_[key] = now_ns;
  return true;
}

void InputRouter::release(InputViewer viewer) {
  const auto is_of_viewer = [viewer](const auto& entry) { return std::get<1>(entry.first) == viewer; };
  const int64_t now_ns = link_.now_ns();
  for (const auto& [key, held] : holds_) {
    if (std::get<1>(key) != viewer) continue;
    wire::InputEvent end = held;
    end.action = InputAction::end;
    end.time_ns = static_cast<uint64_t>(now_ns);
    pending_.erase(key);
    send(std::get<0>(key), std::move(end), now_ns);
  }
  std::erase_if(holds_, is_of_viewer);
  std::erase_if(pending_, is_of_viewer);
  std::erase_if(sent_ns_, is_of_viewer);
}

void InputRouter::update() {
  if (streams_.empty()) return;
  const int64_t now_ns = link_.now_ns();
  const auto declared = [&](const Key& key) {
    const state::Stream* const stream = find(std::get<0>(key));
    return stream ? stream->inputs().find(std::get<2>(key)) : nullptr;
  };
  const auto has_ended = [&](const auto& entry) { return !declared(entry.first); };
  const auto is_refused = [&](const auto& entry) {
    const wire::Input* const input = declared(entry.first);
    return !input || !takes(*input, entry.second);
  };
  std::erase_if(holds_, is_refused);
  std::erase_if(pending_, is_refused);
  std::erase_if(sent_ns_, has_ended);
  std::vector<Key> due;
  for (const auto& [key, event] : pending_)
    if (now_ns - sent_ns_[key] >= kSendPeriodNs) due.push_back(key);
  for (const Key& key : due) flush(key, now_ns);
  for (const auto& [key, held] : holds_) {
    if (now_ns - sent_ns_[key] < kRepeatPeriodNs) continue;
    wire::InputEvent move = held;
    move.action = InputAction::move;
    send(std::get<0>(key), std::move(move), now_ns);
    sent_ns_[key] = now_ns;
  }
}

}  // namespace fire3dv::app
