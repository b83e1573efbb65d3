// Scheduling of the peers' messages on the render thread: one time slice per peer and poll. Other messages
// are deferred to later polls, in order.
#include <algorithm>

#include "base/log.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {

using Kind = transport::LinkEvent::Kind;

namespace {
constexpr int64_t kSlicesAlone = 25;  // time slices of a peer that is alone
// Control messages that take a whole slice throttle their peer, so that they take a quarter of the time at
// most.
constexpr int64_t kThrottleFactor = 3;
}  // namespace

size_t StreamReceiver::DeferredMessage::bytes() const {
  return sizeof(DeferredMessage) + message.size() + text.size();
}

bool StreamReceiver::receive(Peer peer, const transport::LinkEvent& event) {
  if (event.kind == Kind::note) {
    handled_peer_.reset();
    log(warning(event.text));
    return false;
  }
  PeerState& state = peers_[peer];
  if (event.kind == Kind::connected) {
    state.budget = listeners_[peer.first]->budget(peer.second);
    state.host = host_of_peer(budget_of(peer)->name());
  }
  if (event.kind == Kind::pose || event.kind == Kind::control)
    state.last_message_ns = event.received_ns != 0 ? event.received_ns : now_ns_;
  if (event.overtaken != 0) count_overtaken(peer, event.overtaken);
  if (!lockstep_ && state.deferred.empty() && has_time(state)) return handle_timed(peer, state, event);
  store(peer, state, event);
  return false;
}

void StreamReceiver::count_overtaken(Peer peer, uint64_t poses) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream != stream_of_peer_.end()) stream->second.overtaken += poses;
}

bool StreamReceiver::has_time(PeerState& state) {
  const int64_t turn_ns = budgets_->limits().slices.receive_ns * (peers_.size() > 1 ? 1 : kSlicesAlone);
  if (std::exchange(state.poll, polls_) != polls_) state.spent_ns = state.control_ns = 0;
  return state.spent_ns < turn_ns && now_ns_ >= state.throttled_until_ns;
}

void StreamReceiver::add_edit_time(state::StreamId stream, int64_t ns) {
  for (const auto& [peer, published] : stream_of_peer_) {
    if (published.id != stream) continue;
    if (const auto state = peers_.find(peer); state != peers_.end()) add_control_time(state->second, ns);
  }
}

// Throttles the peer after long control messages, for the benefit of the other peers.
void StreamReceiver::add_control_time(PeerState& state, int64_t ns) {
  state.control_ns += ns;
  const bool is_throttled = now_ns_ < state.throttled_until_ns;
  if (peers_.size() <= 1 || (!is_throttled && state.control_ns < budgets_->limits().slices.receive_ns))
    return;
  state.throttled_until_ns = std::max(state.throttled_until_ns, now_ns_) + kThrottleFactor * state.control_ns;
  state.control_ns = 0;
}

bool StreamReceiver::handle_timed(Peer peer, PeerState& state, const transport::LinkEvent& event) {
  const int64_t begin_ns = now_ns_;
  const bool ends = event.kind == Kind::disconnected;
  const bool changed = handle(peer, event);
  handled_peer_.reset();
  now_ns_ = clock_();
  if (ends) return changed;
  const int64_t spent_ns = now_ns_ - begin_ns;
  state.spent_ns += spent_ns;
  if (event.kind == Kind::control) add_control_time(state, spent_ns);
  return changed;
}

bool StreamReceiver::handle_next(Peer peer) {
  PeerState& state = peers_.at(peer);
  const DeferredMessage next = std::move(state.deferred.front());
  state.deferred.pop_front();
  release(state, next.bytes());
  if (state.deferred.empty()) state.deferred_poses.clear();
  if (next.is_dropped) return false;
  return handle_timed(peer, state, {next.kind, peer.second, next.message, next.text, next.received_ns});
}

// Handles deferred messages, one time slice per peer. Each poll begins with another peer.
bool StreamReceiver::handle_deferred() {
  turns_.clear();
  for (const auto& [peer, state] : peers_) {
    if (is_ready(state)) turns_.push_back(peer);
  }
  if (turns_.empty()) return false;
  std::rotate(turns_.begin(), std::upper_bound(turns_.begin(), turns_.end(), last_turn_), turns_.end());
  last_turn_ = turns_.front();
  bool changed = false;
  for (const Peer& peer : turns_) {
    for (auto state = peers_.find(peer);
         state != peers_.end() && is_ready(state->second) && has_time(state->second);
         state = peers_.find(peer)) {
      changed |= handle_next(peer);
    }
  }
  return changed;
}

// Conflicts are decided by the time of a peer's last message, so its link is not paused; nor is that of a
// peer that awaits its stream, so that its end is seen. In lockstep no link is read while messages are
// deferred.
void StreamReceiver::pause_deferred_peers() {
  if (lockstep_) return;
  for (auto& [peer, state] : peers_) {
    const bool is_paused = !state.deferred.empty() && !state.conflict && !state.is_awaiting_stream;
    if (std::exchange(state.is_paused, is_paused) != is_paused)
      listeners_[peer.first]->pause_peer(peer.second, is_paused);
  }
}

// Lockstep: handles messages in order of arrival, until there is a frame to show.
bool StreamReceiver::handle_in_order() {
  for (;;) {
    auto next = peers_.end();
    for (auto peer = peers_.begin(); peer != peers_.end(); ++peer) {
      if (is_ready(peer->second) && (next == peers_.end() || peer->second.deferred.front().number <
                                                                 next->second.deferred.front().number))
        next = peer;
    }
    if (next == peers_.end()) return false;
    if (handle_next(next->first)) return true;
  }
}

void StreamReceiver::store(Peer peer, PeerState& state, const transport::LinkEvent& event) {
  // Disconnected before the decision, or before its description is accepted.
  if (event.kind == Kind::disconnected && (state.conflict || state.is_awaiting_stream)) {
    if (std::exchange(state.is_awaiting_stream, false)) state.throttled_until_ns = 0;
    state.conflict.reset();
    state.deferred.clear();
    state.charge.release();
  }
  if (event.kind == Kind::pose && !lockstep_ && is_whole_frame(event.message))
    drop_deferred_poses(peer, state);
  DeferredMessage deferred{++last_number_,
                           event.kind,
                           {event.message.begin(), event.message.end()},
                           std::string(event.text),
                           event.received_ns};
  const bool is_message = event.kind == Kind::pose || event.kind == Kind::control;
  if (state.deferred.empty() && is_message)
    state.charge = std::move(*BudgetCharge::take(budget_of(peer), Resource::received_bytes, 0));
  const Result<void> fits = state.charge.resize(state.charge.amount() + deferred.bytes());
  // In lockstep nothing may be lost: the link holds the sender back.
  if (!fits && is_message && !lockstep_) {
    const uint32_t bit = 1u << static_cast<uint32_t>(Resource::received_bytes);
    if ((std::exchange(state.reported_refusals, state.reported_refusals | bit) & bit) == 0)
      log(warning("messages of " + listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second) +
                  " are dropped: " + fits.error().message));
    return;
  }
  if (event.kind == Kind::pose && !lockstep_) {
    if (state.deferred_poses.size() > 2 * state.deferred.size() + 64)  // most of them were handled
      std::erase_if(state.deferred_poses, [&](uint64_t n) { return n < state.deferred.front().number; });
    state.deferred_poses.push_back(deferred.number);
  }
  state.deferred.push_back(std::move(deferred));
}

// Defers a message until its conflict is decided.
void StreamReceiver::put_back(Peer peer, const transport::LinkEvent& event) {
  PeerState& state = peers_.at(peer);
  if (state.deferred.empty())
    state.charge = std::move(*BudgetCharge::take(budget_of(peer), Resource::received_bytes, 0));
  state.deferred.push_front(
      {0, event.kind, {event.message.begin(), event.message.end()}, {}, event.received_ns});
  (void)state.charge.resize(state.charge.amount() + state.deferred.front().bytes());
}

// Some messages are deferred without a charge.
void StreamReceiver::release(PeerState& state, size_t bytes) {
  (void)state.charge.resize(state.charge.amount() - std::min<uint64_t>(bytes, state.charge.amount()));
}

// A whole frame replaces all deferred poses of its peer, as in the links.
void StreamReceiver::drop_deferred_poses(Peer peer, PeerState& state) {
  uint64_t dropped = 0;
  for (const uint64_t number : state.deferred_poses) {
    const auto deferred =
        std::lower_bound(state.deferred.begin(), state.deferred.end(), number,
                         [](const DeferredMessage& each, uint64_t n) { return each.number < n; });
    if (deferred == state.deferred.end() || deferred->number != number) continue;
    const size_t before = deferred->bytes();
    deferred->message = {};
    deferred->is_dropped = true;
    ++dropped;
    release(state, before - deferred->bytes());
  }
  count_overtaken(peer, dropped);
  state.deferred_poses.clear();
  while (!state.deferred.empty() && state.deferred.back().is_dropped) {
    release(state, state.deferred.back().bytes());
    state.deferred.pop_back();
  }
}

bool StreamReceiver::is_whole_frame(std::span<const std::byte> message) {
  const Result<wire::Message> decoded = decoder_.decode(message);
  const auto* frame = decoded ? std::get_if<wire::PoseFrameView>(&*decoded) : nullptr;
  return frame && frame->node_indices.empty() && frame->first_node == 0 &&
         frame->poses.size() == frame->node_count;
}

size_t StreamReceiver::deferred_messages() const {
  size_t count = 0;
  for (const auto& [peer, state] : peers_) count += state.deferred.size();
  return count;
}

}  // namespace fire3dv::app
