#include "inputs.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace fire3dv::client {

using wire::InputAction;

void Inputs::declare(const std::string& name, const wire::Input& input) {
  const auto known = declared_.find(name);
  if (known != declared_.end() && known->second.kind != input.kind) clear(name);
  declared_[name] = input;
}

void Inputs::clear(const std::string& name) {
  for (auto each = holds_.begin(); each != holds_.end();) {
    if (std::get<0>(each->first) != name) {
      ++each;
      continue;
    }
    push_end(each->first, each->second.node);
    each = holds_.erase(each);
  }
  declared_.erase(name);
}

void Inputs::restart_epoch() {
  std::erase_if(queue_, [](const wire::InputEvent& event) { return event.action != InputAction::end; });
  for (const auto& [holder, hold] : holds_) push_end(holder, hold.node);
  holds_.clear();
  sources_.clear();
  lost_ = 0;
}

// Numbers that are missing are of events that a link has dropped.
bool Inputs::is_new(const wire::InputEvent& event, uint64_t now_ns) {
  const auto known = sources_.find(event.source);
  if (known == sources_.end() && sources_.size() == kMaxSources)
    sources_.erase(
        std::ranges::min_element(sources_, {}, [](const auto& source) { return source.second.heard_ns; }));
  Source& source = known == sources_.end() ? sources_[event.source] : known->second;
  if (event.sequence <= source.sequence) return false;
  if (source.sequence != 0) lost_ += event.sequence - source.sequence - 1;
  source = {event.sequence, now_ns};
  return true;
}

bool Inputs::begin(Holder holder, const wire::InputEvent& event, uint64_t now_ns) {
  if (holds_.size() == kMaxHolds || queue_.size() >= kMaxQueued) return false;
  holds_[std::move(holder)] = {event.node, now_ns};
  return true;
}

// Returns false for an end without a begin, and for a begin beyond the limit. A move without one goes on with
// a drag that was ended because its renderer was silent: it becomes a begin.
bool Inputs::hold(wire::InputEvent& event, uint64_t now_ns) {
  Holder holder(event.input, event.source, event.viewer);
  const auto known = holds_.find(holder);
  if (event.action == InputAction::begin) {
    if (known != holds_.end()) {  // its end was lost
      push_end(holder, known->second.node);
      holds_.erase(known);
    }
    return begin(std::move(holder), event, now_ns);
  }
  if (known == holds_.end() && event.action == InputAction::move) {
    event.action = InputAction::begin;
    return begin(std::move(holder), event, now_ns);
  }
  if (known == holds_.end() || known->second.node != event.node) return false;
  known->second.heard_ns = now_ns;
  if (event.action == InputAction::end) holds_.erase(known);
  return true;
}

// Of a slider the newest value counts, whoever set it; of a drag the newest move.
void Inputs::drop_older(const wire::InputEvent& event, wire::InputKind kind) {
  if (!is_continuous(kind, event.action)) return;
  const auto is_same = [&](const wire::InputEvent& queued) {
    return queued.input == event.input && (kind != wire::InputKind::drag ||
                                           (queued.source == event.source && queued.viewer == event.viewer));
  };
  const auto last = std::find_if(queue_.rbegin(), queue_.rend(), is_same);
  if (last != queue_.rend() && last->action == event.action) queue_.erase(std::next(last).base());
}

void Inputs::push_end(const Holder& holder, uint32_t node) {
  wire::InputEvent end;
  std::tie(end.input, end.source, end.viewer) = holder;
  end.epoch = epoch_;
  end.action = InputAction::end;
  end.node = node;
  queue_.push_back(std::move(end));
}

void Inputs::on(wire::InputEvent event, uint64_t epoch, uint32_t node_count, uint64_t now_ns) {
  if (event.epoch != epoch || !is_new(event, now_ns)) return;
  epoch_ = epoch;
  const auto declared = declared_.find(event.input);
  const bool is_drag = event.action >= InputAction::begin;
  if (declared == declared_.end() || !takes(declared->second, event) ||
      (is_drag && (event.node >= node_count || !hold(event, now_ns)))) {
    ++lost_;
    return;
  }
  const wire::InputKind kind = declared->second.kind;
  drop_older(event, kind);
  if (queue_.size() >= kMaxQueued && event.action != InputAction::end) {
    ++lost_;
    return;
  }
  queue_.push_back(std::move(event));
}

// A link may count a renderer a moment after its first event.
void Inputs::end_lost_drags(uint64_t now_ns, bool has_renderers) {
  constexpr uint64_t kAbsenceNs = 1'000'000'000;
  const uint64_t timeout_ns = has_renderers ? kHoldTimeoutNs : kAbsenceNs;
  for (auto each = holds_.begin(); each != holds_.end();) {
    if (now_ns - each->second.heard_ns < timeout_ns) {
      ++each;
      continue;
    }
    push_end(each->first, each->second.node);
    each = holds_.erase(each);
  }
}

// Events of inputs that were cleared, or declared otherwise, since they arrived are late: only ends of drags
// count.
std::optional<Inputs::Taken> Inputs::take() {
  while (!queue_.empty()) {
    Taken taken;
    taken.event = std::move(queue_.front());
    queue_.pop_front();
    const auto declared = declared_.find(taken.event.input);
    const bool is_end = taken.event.action == InputAction::end;
    if (!is_end && (declared == declared_.end() || !takes(declared->second, taken.event))) {
      ++lost_;
      continue;
    }
    taken.kind = is_end ? wire::InputKind::drag : declared->second.kind;
    taken.lost = std::exchange(lost_, 0);
    if (!is_end) {
      wire::Input after = declared->second;
      apply(taken.event, after);
      if (after != declared->second) taken.changed = std::move(after);
    }
    return taken;
  }
  return {};
}

}  // namespace fire3dv::client
