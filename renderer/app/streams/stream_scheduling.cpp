// Turns of the peers at the render thread: one time slice per peer and poll; what is left waits, in order,
// for the next poll.
#include <algorithm>

#include "renderer/app/streams/stream_receiver.h"

namespace fire3dv::app {

using Kind = transport::LinkEvent::Kind;

namespace {
constexpr int64_t kSlicesAlone = 25;  // of a peer that nobody waits for
// Control messages that take a whole slice are followed by a rest, so that those of one peer take a quarter
// of the time at most.
constexpr int64_t kRestFactor = 3;
}  // namespace

size_t StreamReceiver::Waiting::bytes() const {
  return sizeof(Waiting) + message.size() + text.size();
}

bool StreamReceiver::receive(Peer peer, const transport::LinkEvent& event) {
  if (event.kind == Kind::note) {
    handled_peer_.reset();
    note(std::string(event.text));
    return false;
  }
  PeerState& state = peers_[peer];
  if (event.kind == Kind::connected) state.budget = listeners_[peer.first]->budget(peer.second);
  if (event.kind == Kind::pose || event.kind == Kind::control)
    state.heard_ns = event.received_ns != 0 ? event.received_ns : now_ns_;
  if (!lockstep_ && state.waiting.empty() && has_time(state)) return handle_timed(peer, state, event);
  store(peer, state, event);
  return false;
}

bool StreamReceiver::has_time(PeerState& state) {
  const int64_t turn_ns = budgets_->limits().slices.receive_ns * (peers_.size() > 1 ? 1 : kSlicesAlone);
  if (std::exchange(state.poll, polls_) != polls_) state.spent_ns = state.unrested_ns = 0;
  return state.spent_ns < turn_ns && now_ns_ >= state.rests_until_ns;
}

void StreamReceiver::add_edit_time(state::StreamId stream, int64_t ns) {
  for (const auto& [peer, published] : stream_of_peer_) {
    if (published.id != stream) continue;
    if (const auto state = peers_.find(peer); state != peers_.end()) add_control_time(state->second, ns);
  }
}

// Others have their turns meanwhile. A peer that is alone does not rest.
void StreamReceiver::add_control_time(PeerState& state, int64_t ns) {
  state.unrested_ns += ns;
  const bool rests = now_ns_ < state.rests_until_ns;
  if (peers_.size() <= 1 || (!rests && state.unrested_ns < budgets_->limits().slices.receive_ns)) return;
  state.rests_until_ns = std::max(state.rests_until_ns, now_ns_) + kRestFactor * state.unrested_ns;
  state.unrested_ns = 0;
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
  const Waiting next = std::move(state.waiting.front());
  state.waiting.pop_front();
  release(state, next.bytes());
  if (state.waiting.empty()) state.waiting_poses.clear();
  if (next.is_dropped) return false;
  return handle_timed(peer, state, {next.kind, peer.second, next.message, next.text, next.received_ns});
}

// What waits of each peer, for one slice each. Another one begins in each poll.
bool StreamReceiver::handle_waiting() {
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

// Contests are decided by when a peer was heard last, so its messages go on coming. In lockstep no link is
// read while messages wait.
void StreamReceiver::pause_waiting_peers() {
  if (lockstep_) return;
  for (auto& [peer, state] : peers_) {
    const bool is_paused = !state.waiting.empty() && !state.contest;
    if (std::exchange(state.is_paused, is_paused) != is_paused)
      listeners_[peer.first]->pause_peer(peer.second, is_paused);
  }
}

// Lockstep: messages in the order of their arrival, until there is a frame to show.
bool StreamReceiver::handle_in_order() {
  for (;;) {
    auto next = peers_.end();
    for (auto peer = peers_.begin(); peer != peers_.end(); ++peer) {
      if (is_ready(peer->second) &&
          (next == peers_.end() || peer->second.waiting.front().number < next->second.waiting.front().number))
        next = peer;
    }
    if (next == peers_.end()) return false;
    if (handle_next(next->first)) return true;
  }
}

void StreamReceiver::store(Peer peer, PeerState& state, const transport::LinkEvent& event) {
  if (event.kind == Kind::disconnected && state.contest) {  // it left before it was decided
    state.contest.reset();
    state.waiting.clear();
    state.charge.release();
  }
  if (event.kind == Kind::pose && !lockstep_ && is_whole_frame(event.message)) drop_waiting_poses(state);
  Waiting waiting{++last_number_,
                  event.kind,
                  {event.message.begin(), event.message.end()},
                  std::string(event.text),
                  event.received_ns};
  const bool is_message = event.kind == Kind::pose || event.kind == Kind::control;
  if (state.waiting.empty() && is_message)
    state.charge = std::move(*BudgetCharge::take(budget_of(peer), Resource::received_bytes, 0));
  const Result<void> fits = state.charge.resize(state.charge.amount() + waiting.bytes());
  // In lockstep nothing may be lost: the link holds the sender back.
  if (!fits && is_message && !lockstep_) {
    const uint32_t bit = 1u << static_cast<uint32_t>(Resource::received_bytes);
    if ((std::exchange(state.refusals_told, state.refusals_told | bit) & bit) == 0)
      note("messages of " + listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second) +
           " are dropped: " + fits.error().message);
    return;
  }
  if (event.kind == Kind::pose && !lockstep_) {
    if (state.waiting_poses.size() > 2 * state.waiting.size() + 64)  // most of them were handled
      std::erase_if(state.waiting_poses, [&](uint64_t n) { return n < state.waiting.front().number; });
    state.waiting_poses.push_back(waiting.number);
  }
  state.waiting.push_back(std::move(waiting));
}

// A message that is handled again when its contest is decided.
void StreamReceiver::put_back(Peer peer, const transport::LinkEvent& event) {
  PeerState& state = peers_.at(peer);
  if (state.waiting.empty())
    state.charge = std::move(*BudgetCharge::take(budget_of(peer), Resource::received_bytes, 0));
  state.waiting.push_front(
      {0, event.kind, {event.message.begin(), event.message.end()}, {}, event.received_ns});
  (void)state.charge.resize(state.charge.amount() + state.waiting.front().bytes());
}

// Some messages may wait without a charge.
void StreamReceiver::release(PeerState& state, size_t bytes) {
  (void)state.charge.resize(state.charge.amount() - std::min<uint64_t>(bytes, state.charge.amount()));
}

// A whole frame takes the place of all poses of its peer that wait, as in the links.
void StreamReceiver::drop_waiting_poses(PeerState& state) {
  for (const uint64_t number : state.waiting_poses) {
    const auto waiting = std::lower_bound(state.waiting.begin(), state.waiting.end(), number,
                                          [](const Waiting& each, uint64_t n) { return each.number < n; });
    if (waiting == state.waiting.end() || waiting->number != number) continue;
    const size_t before = waiting->bytes();
    waiting->message = {};
    waiting->is_dropped = true;
    release(state, before - waiting->bytes());
  }
  state.waiting_poses.clear();
  while (!state.waiting.empty() && state.waiting.back().is_dropped) {
    release(state, state.waiting.back().bytes());
    state.waiting.pop_back();
  }
}

bool StreamReceiver::is_whole_frame(std::span<const std::byte> message) {
  const Result<wire::Message> decoded = decoder_.decode(message);
  const auto* frame = decoded ? std::get_if<wire::PoseFrameView>(&*decoded) : nullptr;
  return frame && frame->node_indices.empty() && frame->first_node == 0 &&
         frame->poses.size() == frame->node_count;
}

size_t StreamReceiver::waiting_messages() const {
  size_t count = 0;
  for (const auto& [peer, state] : peers_) count += state.waiting.size();
  return count;
}

}  // namespace fire3dv::app
