#include "renderer/streams/stream_receiver.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <thread>

#include "base/clock.h"
#include "base/log.h"
#include "protocol/wire/encode.h"

namespace fire3dv::app {

const char* refusal_name(Refusal refusal) {
  switch (refusal) {
    case Refusal::unreadable:
      return "unreadable";
    case Refusal::before_description:
      return "before_description";
    case Refusal::wrong_way:
      return "wrong_way";
    case Refusal::version:
      return "version";
  }
  return "";
}

StreamReceiver::StreamReceiver(state::PoseState& poses, bool lockstep, const PlayOptions& play,
                               std::shared_ptr<BudgetPool> budgets)
    : poses_(poses),
      lockstep_(lockstep),
      play_(play),
      budgets_(budgets ? std::move(budgets) : BudgetPool::create()),
      clock_{monotonic_ns},
      scheduler_(
          lockstep, clock_, budgets_,
          {.handle =
               [this](Peer peer, const transport::LinkEvent& event) {
                 const bool changed = handle(peer, event);
                 handled_peer_.reset();
                 return changed;
               },
           .budget = [this](Peer peer) { return budget_of(peer); },
           .pause = [this](Peer peer,
                           bool is_paused) { listeners_[peer.first]->pause_peer(peer.second, is_paused); },
           .overtaken = [this](Peer peer, uint64_t count) { count_overtaken(peer, count); },
           .dropped =
               [this](Peer peer, const std::string& reason) {
                 log(warning("messages of " + listeners_[peer.first]->uri() + " peer " +
                             std::to_string(peer.second) + " are dropped: " + reason));
               }}),
      images_(poses, [this](std::string text) { log(std::move(text)); }),
      inputs_(poses, {.carries_input =
                          [this](uint64_t epoch) {
                            const std::optional<Peer> peer = peer_of(epoch);
                            return peer && listeners_[peer->first]->carries_input();
                          },
                      .send =
                          [this](uint64_t epoch, const wire::InputEvent& event) {
                            if (const std::optional<Peer> peer = peer_of(epoch))
                              reply(*peer, wire::encode(event));
                          },
                      .now_ns = [this] { return clock_.read_ns(); }}) {}

std::optional<StreamReceiver::Peer> StreamReceiver::peer_of(uint64_t epoch) const {
  for (const auto& [peer, stream] : stream_of_peer_)
    if (stream.epoch == epoch) return peer;
  return {};
}

std::shared_ptr<PeerBudget> StreamReceiver::budget_of(Peer peer) {
  std::shared_ptr<PeerBudget>& budget = peers_[peer].budget;
  if (!budget) budget = listeners_[peer.first]->budget(peer.second);
  if (!budget)
    budget = budgets_->add_peer(listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second));
  return budget;
}

void StreamReceiver::add(std::unique_ptr<transport::ListenerLink> listener) {
  listeners_.push_back(std::move(listener));
}

bool StreamReceiver::poll() {
  poll_ = scheduler_.begin_poll();
  clock_.update();
  bool changed = !lockstep_ && scheduler_.handle_deferred();
  scheduler_.pause_deferred_peers();
  const bool reads = !lockstep_ || !scheduler_.has_ready();
  for (size_t i = 0; reads && i < listeners_.size(); ++i) {
    listeners_[i]->poll([&](const transport::LinkEvent& event) {
      if (watcher_) watcher_(i, event);
      changed |= receive({i, event.peer}, event);
    });
  }
  resolve_conflicts();
  scheduler_.pause_deferred_peers();
  if (lockstep_) changed |= scheduler_.handle_in_order();
  clock_.update();
  changed |= poses_.advance(clock_.now_ns);
  report_refusals();
  report_bindings(false);
  report_poses();
  inputs_.update();
  send_clock_pings();
  report_conditions();
  return changed;
}

void StreamReceiver::wait(std::chrono::nanoseconds timeout) {
  if (scheduler_.has_ready()) return;
  if (listeners_.empty()) return std::this_thread::sleep_for(timeout);
  // Several listeners take turns with a share of the timeout.
  for (const auto& listener : listeners_) listener->wait(timeout / static_cast<int64_t>(listeners_.size()));
}

void StreamReceiver::play(uint64_t epoch, bool interpolate, std::optional<int64_t> delay_ns) {
  if (lockstep_) return;
  for (auto& [peer, stream] : stream_of_peer_) {
    if (stream.epoch != epoch) continue;
    const bool same_delay = !interpolate || stream.delay_ns == delay_ns;
    if (stream.interpolated == interpolate && same_delay) return;
    stream.interpolated = interpolate;
    stream.delay_ns = delay_ns;
    if (interpolate) {
      poses_.interpolate(stream.id, delay_ns);
    } else {
      poses_.show_newest(stream.id, clock_.read_ns());
    }
  }
}

// Clock offset pings to other machines: frequent at first, then often enough for drift.
void StreamReceiver::send_clock_pings() {
  const int64_t now_ns = clock_.now_ns;
  constexpr int64_t kFirstEveryNs = 100'000'000, kLaterEveryNs = 1'000'000'000;
  constexpr uint64_t kFirst = 10;
  for (auto& [peer, stream] : stream_of_peer_) {
    if (!stream.interpolated || stream.clock.source() == state::ClockOffset::Source::same_clock ||
        now_ns < stream.next_ping_ns)
      continue;
    stream.next_ping_ns = now_ns + (stream.pings < kFirst ? kFirstEveryNs : kLaterEveryNs);
    reply(peer, wire::encode(wire::Ping{++stream.pings, static_cast<uint64_t>(now_ns)}));
  }
}

// Reports only lost and recovered streams: a pausing simulator becomes late regularly.
void StreamReceiver::report_conditions() {
  // After a pause, also one of this program, the first frame needs a moment.
  constexpr int64_t kResumeNs = 1'000'000'000;
  if (clock_.now_ns - std::exchange(conditions_at_ns_, clock_.now_ns) > kResumeNs)
    expects_since_ns_ = clock_.now_ns;
  if (!expects_frames_ || clock_.now_ns - expects_since_ns_ < kResumeNs) return;
  for (auto& [peer, stream] : stream_of_peer_) {
    report_losses(peer, stream);
    // Parts that arrive without a whole frame are reported as such, with another remedy.
    bool is_lost =
        !stream.losses.is_lossy() && poses_.streams()[stream.id].condition == state::Condition::lost;
    const bool waits = is_lost && images_.owes_image(stream.requester, clock_.now_ns);
    if (!std::exchange(stream.reported_waiting, waits) && waits)
      log(warning("images for stream \"" + stream.name +
                  "\" take several seconds, and it waits for them; fire3dv-inspect and --metrics list what "
                  "each stream costs"));
    is_lost &= !waits;
    if (std::exchange(stream.reported_lost, is_lost) == is_lost) continue;
    const std::string name = "stream \"" + stream.name + "\"";
    log(is_lost ? warning(name + " stalled: no pose frames; showing the last one")
                : name + " sends frames again");
  }
}

void StreamReceiver::report_losses(Peer peer, PeerStream& stream) {
  const stream::FrameAssembler& frames = poses_.streams()[stream.id].assembler();
  using Change = FrameLossMonitor::Change;
  const Change change = stream.losses.update(frames.opened(), frames.completed(), clock_.now_ns);
  if (change == Change::none) return;
  const std::string name = "stream \"" + stream.name + "\"";
  if (change == Change::whole) return log(name + ": its frames are whole again");
  char counts[64];
  std::snprintf(counts, sizeof counts, "%.0f of %.0f a second", stream.losses.missing_per_s(),
                stream.losses.begun_per_s());
  log(warning(name + ": frames come incomplete (" + counts + "): parts of them are lost or too late on " +
              listeners_[peer.first]->uri() +
              "; use tcp:// or tls:// there, ?parity=25 to a group, or smaller frames"));
}

bool StreamReceiver::receive(Peer peer, const transport::LinkEvent& event) {
  using Kind = transport::LinkEvent::Kind;
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
    state.last_message_ns = event.received_ns != 0 ? event.received_ns : clock_.now_ns;
  if (event.kind == Kind::disconnected) state.conflict.reset();
  if (event.overtaken != 0) count_overtaken(peer, event.overtaken);
  return scheduler_.receive(peer, event);
}

void StreamReceiver::count_overtaken(Peer peer, uint64_t poses) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream != stream_of_peer_.end()) stream->second.overtaken += poses;
}

void StreamReceiver::add_edit_time(state::StreamId stream, int64_t ns) {
  for (const auto& [peer, published] : stream_of_peer_) {
    if (published.id == stream) scheduler_.add_control_time(peer, ns);
  }
}

bool StreamReceiver::handle(Peer peer, const transport::LinkEvent& event) {
  using Kind = transport::LinkEvent::Kind;
  const Kind kind = event.kind;
  handled_peer_ = peer;
  switch (kind) {
    case Kind::connected:
    case Kind::note:
      return false;
    case Kind::disconnected: {
      suspend_stream(peer, std::string(event.text), true);
      peers_.erase(peer);
      scheduler_.remove(peer);
      return false;
    }
    case Kind::pose:
    case Kind::control:
      break;
  }

  Result<wire::Message> decoded = decoder_.decode_in_place(event.message);
  if (!decoded) {
    reject(peer, Refusal::unreadable, decoded.error().message);
    if (const auto& request = decoder_.refused_request(); request && request->id != 0) {
      images_.send_refusal(
          *listeners_[peer.first], peer.second,
          {request->epoch, request->id, wire::ImageRefusal::bad_request, decoded.error().message});
      return false;
    }
    // An unreadable message may have been a description, so its adapter gets a reply, at most one per poll.
    if (kind == Kind::control && std::exchange(peers_[peer].answered_poll, poll_) != poll_) {
      refuse_description(peer, 0, wire::WelcomeStatus::bad_description, decoded.error().message);
    }
    return false;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded))
    return receive_frame(peer, *frame, event.received_ns);
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (!handle_description(peer, *description)) scheduler_.put_back(peer, event);
    return false;
  }
  if (auto* edit = std::get_if<wire::SceneEdit>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    if (stream != stream_of_peer_.end()) return poses_.apply(stream->second.id, std::move(*edit));
    reject(peer, Refusal::before_description, "scene edit before a description");
    return false;
  }
  if (const auto* edit = std::get_if<wire::UnknownEdit>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    return stream != stream_of_peer_.end() && poses_.apply(stream->second.id, *edit);
  }
  if (const auto* request = std::get_if<wire::ImageRequest>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    if (stream != stream_of_peer_.end())
      images_.request(stream->second.requester, *request, budget_of(peer));
    else
      reject(peer, Refusal::before_description, "image request before a description");
    return false;
  }
  if (const auto* ping = std::get_if<wire::Ping>(&*decoded)) {
    reply(peer,
          wire::encode(wire::Pong{ping->id, ping->sender_time_ns, static_cast<uint64_t>(monotonic_ns())}));
    return false;
  }
  if (std::holds_alternative<wire::Goodbye>(*decoded)) {
    end_stream(peer, "it said goodbye");
    return false;  // no image needed: in lockstep, images are of pose frames only
  }
  if (const auto* pong = std::get_if<wire::Pong>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    const bool is_expected =
        stream != stream_of_peer_.end() && pong->id != 0 && pong->id <= stream->second.pings;
    const int64_t came_ns = event.received_ns != 0 ? event.received_ns : clock_.now_ns;
    if (is_expected && pong->ping_sender_time_ns <= static_cast<uint64_t>(came_ns))
      stream->second.clock.on_pong(static_cast<int64_t>(pong->ping_sender_time_ns), pong->answer_time_ns,
                                   came_ns);
    return false;
  }
  if (std::holds_alternative<wire::UnknownMessage>(*decoded)) return false;  // of a later minor version
  reject(peer, Refusal::wrong_way, "a message that only renderers send");
  return false;
}

bool StreamReceiver::receive_frame(Peer peer, const wire::PoseFrameView& frame, int64_t received_ns) {
  const auto stream = stream_of_peer_.find(peer);
  if (stream == stream_of_peer_.end()) {
    reject(peer, Refusal::before_description, "pose frame before a description");
    return false;
  }
  const int64_t came_ns = received_ns != 0 ? received_ns : clock_.now_ns;
  state::ClockOffset& clock = stream->second.clock;
  clock.on_frame(frame.header.publish_time_ns, came_ns);
  return poses_.push(stream->second.id, frame, clock.soonest_ns(frame.header.publish_time_ns), came_ns);
}

void StreamReceiver::acknowledge(const std::vector<state::FrameTag>& shown) {
  for (const state::FrameTag& tag : shown) {
    for (auto& [peer, stream] : stream_of_peer_) {
      // Once per frame, not per image: a paused simulator must not be flooded.
      if (stream.epoch != tag.epoch || stream.acked_sequence >= tag.sequence) continue;
      stream.acked_sequence = tag.sequence;
      reply(peer, wire::encode(wire::Ack{tag.epoch, tag.sequence}));
    }
  }
}

void StreamReceiver::reply(Peer peer, const wire::Bytes& message) {
  listeners_[peer.first]->send(peer.second, message);
}

// Logs the first invalid message of a peer and counts the others: a broken adapter at 1 kHz must not flood
// the terminal.
void StreamReceiver::reject(Peer peer, Refusal refusal, const std::string& reason) {
  ++refusals_[static_cast<size_t>(refusal)];
  if (peers_[peer].rejected++ == 0) {
    log(warning("dropped a message from " + listeners_[peer.first]->uri() + " peer " +
                std::to_string(peer.second) + ": " + reason));
  }
}

void StreamReceiver::log(std::string text) {
  const auto peer = handled_peer_ ? peers_.find(*handled_peer_) : peers_.end();
  log_.add(std::move(text), peer != peers_.end() ? &peer->second.log_limit : nullptr, clock_.now_ns);
}

uint64_t StreamReceiver::rejected_messages() const {
  return std::accumulate(refusals_.begin(), refusals_.end(), uint64_t{0});
}

std::vector<StreamReceiver::LinkReport> StreamReceiver::links() const {
  std::vector<LinkReport> links;
  for (const auto& listener : listeners_) links.push_back({listener->uri(), listener->stats()});
  return links;
}

std::vector<StreamReceiver::Report> StreamReceiver::report() const {
  std::vector<Report> streams;
  for (const auto& [peer, stream] : stream_of_peer_) {
    const auto state = peers_.find(peer);
    streams.push_back({stream.id, listeners_[peer.first]->uri(), stream.clock.source(),
                       state == peers_.end() ? nullptr : state->second.budget, stream.overtaken});
  }
  return streams;
}

std::optional<int64_t> StreamReceiver::published_ns(uint64_t epoch, uint64_t publish_time_ns) const {
  for (const auto& [peer, stream] : stream_of_peer_) {
    if (stream.epoch != epoch || stream.clock.source() == state::ClockOffset::Source::none) continue;
    return stream.clock.local_ns(publish_time_ns);
  }
  return {};
}

}  // namespace fire3dv::app
