#include "renderer/streams/message_scheduler.h"

#include <algorithm>

namespace fire3dv::app {

using Kind = transport::LinkEvent::Kind;

namespace {
constexpr int64_t kSlicesAlone = 25;  // time slices of a peer that is alone
// Control messages that take a whole slice throttle their peer, so that they take a quarter of the time at
// most.
constexpr int64_t kThrottleFactor = 3;
}  // namespace

MessageScheduler::MessageScheduler(bool lockstep, PollClock& clock, std::shared_ptr<const BudgetPool> budgets,
                                   Hooks hooks)
    : lockstep_(lockstep), clock_(clock), budgets_(std::move(budgets)), hooks_(std::move(hooks)) {}

size_t MessageScheduler::Deferred::bytes() const {
  return sizeof(Deferred) + message.size() + text.size();
}

bool MessageScheduler::receive(LinkPeer peer, const transport::LinkEvent& event) {
  Entry& entry = entries_[peer];
  if (!lockstep_ && entry.deferred.empty() && has_time(entry)) return handle_timed(peer, entry, event);
  store(peer, entry, event);
  return false;
}

bool MessageScheduler::has_time(Entry& entry) const {
  const int64_t turn_ns = budgets_->limits().slices.receive_ns * (entries_.size() > 1 ? 1 : kSlicesAlone);
  if (std::exchange(entry.poll, polls_) != polls_) entry.spent_ns = entry.control_ns = 0;
  return entry.spent_ns < turn_ns && clock_.now_ns >= entry.throttled_until_ns;
}

void MessageScheduler::await_stream(LinkPeer peer, int64_t until_ns) {
  Entry& entry = entries_[peer];
  entry.is_awaiting_stream = true;
  entry.throttled_until_ns = std::max(entry.throttled_until_ns, until_ns);
}

void MessageScheduler::add_control_time(LinkPeer peer, int64_t ns) {
  if (const auto entry = entries_.find(peer); entry != entries_.end()) add_control_time(entry->second, ns);
}

void MessageScheduler::add_control_time(Entry& entry, int64_t ns) {
  entry.control_ns += ns;
  const bool is_throttled = clock_.now_ns < entry.throttled_until_ns;
  if (entries_.size() <= 1 || (!is_throttled && entry.control_ns < budgets_->limits().slices.receive_ns))
    return;
  entry.throttled_until_ns =
      std::max(entry.throttled_until_ns, clock_.now_ns) + kThrottleFactor * entry.control_ns;
  entry.control_ns = 0;
}

bool MessageScheduler::handle_timed(LinkPeer peer, Entry& entry, const transport::LinkEvent& event) {
  const int64_t begin_ns = clock_.now_ns;
  const bool ends = event.kind == Kind::disconnected;
  const bool changed = hooks_.handle(peer, event);
  clock_.update();
  if (ends) return changed;
  const int64_t spent_ns = clock_.now_ns - begin_ns;
  entry.spent_ns += spent_ns;
  if (event.kind == Kind::control) add_control_time(entry, spent_ns);
  return changed;
}

bool MessageScheduler::handle_next(LinkPeer peer) {
  Entry& entry = entries_.at(peer);
  const Deferred next = std::move(entry.deferred.front());
  entry.deferred.pop_front();
  release(entry, next.bytes());
  if (entry.deferred.empty()) entry.deferred_poses.clear();
  if (next.is_dropped) return false;
  return handle_timed(peer, entry, {next.kind, peer.second, next.message, next.text, next.received_ns});
}

// Handles deferred messages, one time slice per peer. Each poll begins with another peer.
bool MessageScheduler::handle_deferred() {
  turns_.clear();
  for (const auto& [peer, entry] : entries_) {
    if (is_ready(entry)) turns_.push_back(peer);
  }
  if (turns_.empty()) return false;
  std::rotate(turns_.begin(), std::upper_bound(turns_.begin(), turns_.end(), last_turn_), turns_.end());
  last_turn_ = turns_.front();
  bool changed = false;
  for (const LinkPeer& peer : turns_) {
    for (auto entry = entries_.find(peer);
         entry != entries_.end() && is_ready(entry->second) && has_time(entry->second);
         entry = entries_.find(peer)) {
      changed |= handle_next(peer);
    }
  }
  return changed;
}

// Conflicts are decided by the time of a peer's last message, so its link is not paused; nor is that of a
// peer that awaits its stream, so that its end is seen. In lockstep no link is read while messages are
// deferred.
void MessageScheduler::pause_deferred_peers() {
  if (lockstep_) return;
  for (auto& [peer, entry] : entries_) {
    const bool is_paused = !entry.deferred.empty() && !entry.is_held && !entry.is_awaiting_stream;
    if (std::exchange(entry.is_paused, is_paused) != is_paused) hooks_.pause(peer, is_paused);
  }
}

// Lockstep: handles messages in order of arrival, until there is a frame to show.
bool MessageScheduler::handle_in_order() {
  for (;;) {
    auto next = entries_.end();
    for (auto peer = entries_.begin(); peer != entries_.end(); ++peer) {
      if (is_ready(peer->second) && (next == entries_.end() || peer->second.deferred.front().number <
                                                                   next->second.deferred.front().number))
        next = peer;
    }
    if (next == entries_.end()) return false;
    if (handle_next(next->first)) return true;
  }
}

void MessageScheduler::store(LinkPeer peer, Entry& entry, const transport::LinkEvent& event) {
  // Disconnected before the decision, or before its description is accepted.
  if (event.kind == Kind::disconnected && (entry.is_held || entry.is_awaiting_stream)) {
    if (std::exchange(entry.is_awaiting_stream, false)) entry.throttled_until_ns = 0;
    entry.is_held = false;
    entry.deferred.clear();
    entry.charge.release();
  }
  if (event.kind == Kind::pose && !lockstep_ && is_whole_frame(event.message))
    drop_deferred_poses(peer, entry);
  Deferred deferred{++last_number_,
                    event.kind,
                    {event.message.begin(), event.message.end()},
                    std::string(event.text),
                    event.received_ns};
  const bool is_message = event.kind == Kind::pose || event.kind == Kind::control;
  if (entry.deferred.empty() && is_message)
    entry.charge = std::move(*BudgetCharge::take(hooks_.budget(peer), Resource::received_bytes, 0));
  const Result<void> fits = entry.charge.resize(entry.charge.amount() + deferred.bytes());
  // In lockstep nothing may be lost: the link holds the sender back.
  if (!fits && is_message && !lockstep_) {
    if (!std::exchange(entry.has_reported_drop, true)) hooks_.dropped(peer, fits.error().message);
    return;
  }
  if (event.kind == Kind::pose && !lockstep_) {
    if (entry.deferred_poses.size() > 2 * entry.deferred.size() + 64)  // most of them were handled
      std::erase_if(entry.deferred_poses, [&](uint64_t n) { return n < entry.deferred.front().number; });
    entry.deferred_poses.push_back(deferred.number);
  }
  entry.deferred.push_back(std::move(deferred));
}

// Defers a message until its conflict is decided.
void MessageScheduler::put_back(LinkPeer peer, const transport::LinkEvent& event) {
  Entry& entry = entries_.at(peer);
  if (entry.deferred.empty())
    entry.charge = std::move(*BudgetCharge::take(hooks_.budget(peer), Resource::received_bytes, 0));
  entry.deferred.push_front(
      {0, event.kind, {event.message.begin(), event.message.end()}, {}, event.received_ns});
  (void)entry.charge.resize(entry.charge.amount() + entry.deferred.front().bytes());
}

// Some messages are deferred without a charge.
void MessageScheduler::release(Entry& entry, size_t bytes) {
  (void)entry.charge.resize(entry.charge.amount() - std::min<uint64_t>(bytes, entry.charge.amount()));
}

// A whole frame replaces all deferred poses of its peer, as in the links.
void MessageScheduler::drop_deferred_poses(LinkPeer peer, Entry& entry) {
  uint64_t dropped = 0;
  for (const uint64_t number : entry.deferred_poses) {
    const auto deferred = std::lower_bound(entry.deferred.begin(), entry.deferred.end(), number,
                                           [](const Deferred& each, uint64_t n) { return each.number < n; });
    if (deferred == entry.deferred.end() || deferred->number != number) continue;
    const size_t before = deferred->bytes();
    deferred->message = {};
    deferred->is_dropped = true;
    ++dropped;
    release(entry, before - deferred->bytes());
  }
  hooks_.overtaken(peer, dropped);
  entry.deferred_poses.clear();
  while (!entry.deferred.empty() && entry.deferred.back().is_dropped) {
    release(entry, entry.deferred.back().bytes());
    entry.deferred.pop_back();
  }
}

bool MessageScheduler::is_whole_frame(std::span<const std::byte> message) {
  const Result<wire::Message> decoded = decoder_.decode(message);
  const auto* frame = decoded ? std::get_if<wire::PoseFrameView>(&*decoded) : nullptr;
  return frame && frame->node_indices.empty() && frame->first_node == 0 &&
         frame->poses.size() == frame->node_count;
}

bool MessageScheduler::has_ready() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [this](const auto& entry) { return is_ready(entry.second); });
}

size_t MessageScheduler::deferred_messages() const {
  size_t count = 0;
  for (const auto& [peer, entry] : entries_) count += entry.deferred.size();
  return count;
}

}  // namespace fire3dv::app
