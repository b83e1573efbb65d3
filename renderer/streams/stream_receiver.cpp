#include "renderer/streams/stream_receiver.h"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <thread>

#include "base/clock.h"
#include "base/log.h"
#include "protocol/wire/encode.h"

namespace fire3dv::app {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;
constexpr uint32_t kLogsPerSecond = 10, kTotalLogsPerSecond = 200;

}  // namespace

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
      clock_(monotonic_ns) {}

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
  ++polls_;
  now_ns_ = clock_();
  bool changed = !lockstep_ && handle_deferred();
  pause_deferred_peers();
  const bool reads = !lockstep_ || std::none_of(peers_.begin(), peers_.end(),
                                                [this](const auto& entry) { return is_ready(entry.second); });
  for (size_t i = 0; reads && i < listeners_.size(); ++i) {
    listeners_[i]->poll([&](const transport::LinkEvent& event) {
      if (watcher_) watcher_(i, event);
      changed |= receive({i, event.peer}, event);
    });
  }
  resolve_conflicts();
  pause_deferred_peers();
  if (lockstep_) changed |= handle_in_order();
  now_ns_ = clock_();
  changed |= poses_.advance(now_ns_);
  report_refusals();
  report_bindings(false);
  report_poses();
  send_clock_pings(now_ns_);
  report_conditions();
  return changed;
}

void StreamReceiver::wait(std::chrono::nanoseconds timeout) {
  if (std::any_of(peers_.begin(), peers_.end(), [this](const auto& entry) { return is_ready(entry.second); }))
    return;
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
      poses_.show_newest(stream.id, clock_());
    }
  }
}

// Clock offset pings to other machines: frequent at first, then often enough for drift.
void StreamReceiver::send_clock_pings(int64_t now_ns) {
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
  if (now_ns_ - std::exchange(conditions_at_ns_, now_ns_) > kResumeNs) expects_since_ns_ = now_ns_;
  if (!expects_frames_ || now_ns_ - expects_since_ns_ < kResumeNs) return;
  for (auto& [peer, stream] : stream_of_peer_) {
    report_losses(peer, stream);
    // Parts that arrive without a whole frame are reported as such, with another remedy.
    bool is_lost =
        !stream.losses.is_lossy() && poses_.streams()[stream.id].condition == state::Condition::lost;
    // A simulator that waits for an image sends no frame meanwhile.
    const bool waits = is_lost && image_handler_ && image_handler_->owes_image(stream.requester, now_ns_);
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
  const Change change = stream.losses.update(frames.opened(), frames.completed(), now_ns_);
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
      send_refusal(peer,
                   {request->epoch, request->id, wire::ImageRefusal::bad_request, decoded.error().message});
      return false;
    }
    // An unreadable message may have been a description, so its adapter gets a reply, at most one per poll.
    if (kind == Kind::control && std::exchange(peers_[peer].answered_poll, polls_) != polls_) {
      refuse_description(peer, 0, wire::WelcomeStatus::bad_description, decoded.error().message);
    }
    return false;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded))
    return receive_frame(peer, *frame, event.received_ns);
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    if (!handle_description(peer, *description)) put_back(peer, event);
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
    route_image_request(peer, *request);
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
    const int64_t came_ns = event.received_ns != 0 ? event.received_ns : now_ns_;
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
  const int64_t came_ns = received_ns != 0 ? received_ns : now_ns_;
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

bool StreamReceiver::RateLimit::take(int64_t now_ns, uint32_t per_second) {
  if (used == 0 || now_ns - since_ns >= kSecondNs) {
    since_ns = now_ns;
    used = 0;
  }
  if (used == per_second) return false;
  ++used;
  return true;
}

// Rate limit of notes: a peer that reconnects a thousand times a second must neither flood the terminal nor
// suppress the notes of others.
void StreamReceiver::log(std::string text) {
  const auto peer = handled_peer_ ? peers_.find(*handled_peer_) : peers_.end();
  if ((peer != peers_.end() && !peer->second.log_limit.take(now_ns_, kLogsPerSecond)) ||
      !total_log_limit_.take(now_ns_, kTotalLogsPerSecond)) {
    ++suppressed_logs_;
    return;
  }
  if (total_log_limit_.used == 1 && suppressed_logs_ != 0)
    log_messages_.push_back("and " + std::to_string(std::exchange(suppressed_logs_, 0)) +
                            " more such events");
  log_messages_.push_back(std::move(text));
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

std::vector<std::string> StreamReceiver::take_log_messages() {
  return std::exchange(log_messages_, {});
}

}  // namespace fire3dv::app
