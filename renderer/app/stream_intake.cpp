#include "renderer/app/stream_intake.h"

#include <algorithm>
#include <fstream>
#include <numeric>
#include <utility>

#include "protocol/wire/encode.h"
#include "renderer/app/version.h"

namespace fire3dv::app {
namespace {

constexpr size_t kNamesInNote = 5;
constexpr size_t kNameBytesInWelcome =
    16 << 10;  // of each list: an answer must fit what every link carries back

std::string list_names(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kNamesInNote); ++i)
    text += (i ? ", \"" : "\"") + names[i] + "\"";
  if (names.size() > kNamesInNote) text += " and " + std::to_string(names.size() - kNamesInNote) + " more";
  return text;
}

std::vector<std::string> first_names(const std::vector<std::string>& names) {
  std::vector<std::string> first;
  size_t bytes = 0;
  for (const std::string& name : names) {
    bytes += name.size() + 8;  // with what the encoding adds
    if (bytes > kNameBytesInWelcome) break;
    first.push_back(name);
  }
  return first;
}

std::string renderer_name() {
  return std::string("fire3dv ") + kVersion;
}

// Never empty, so that a publisher that does not know its own is not taken for one of this machine.
const std::string& boot_id() {
  static const std::string id = [] {
    std::string text;
    std::ifstream("/proc/sys/kernel/random/boot_id") >> text;
    return text.empty() ? "unknown" : text;
  }();
  return id;
}

uint64_t monotonic_now_ns() {
  return static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch() /
                               std::chrono::nanoseconds(1));
}

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

StreamIntake::StreamIntake(state::PoseState& poses, bool lockstep, const PlayOptions& play,
                           std::shared_ptr<BudgetPool> budgets)
    : poses_(poses),
      lockstep_(lockstep),
      play_(play),
      budgets_(budgets ? std::move(budgets) : BudgetPool::create()) {}

std::shared_ptr<PeerBudget> StreamIntake::budget_of(Peer peer) {
  std::shared_ptr<PeerBudget>& budget = budget_of_peer_[peer];
  if (!budget) budget = listeners_[peer.first]->budget(peer.second);
  if (!budget)
    budget = budgets_->add_peer(listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second));
  return budget;
}

void StreamIntake::add(std::unique_ptr<transport::ListenerLink> listener) {
  listeners_.push_back(std::move(listener));
}

bool StreamIntake::poll() {
  bool changed = false;
  if (held_.empty()) {
    for (size_t i = 0; i < listeners_.size(); ++i) {
      listeners_[i]->poll([&](const transport::LinkEvent& event) {
        const Peer peer{i, event.peer};
        if (watcher_) watcher_(i, event);
        if (!lockstep_) {
          changed |= handle(peer, event.kind, event.message, event.text, event.received_ns);
          return;
        }
        held_.push_back({peer,
                         event.kind,
                         {event.message.begin(), event.message.end()},
                         std::string(event.text),
                         event.received_ns});
      });
    }
  }
  while (!changed && !held_.empty()) {
    const Held held = std::move(held_.front());
    held_.pop_front();
    changed = handle(held.peer, held.kind, held.message, held.text, held.received_ns);
  }
  const auto now_ns = static_cast<int64_t>(monotonic_now_ns());
  changed |= poses_.advance(now_ns);
  ask_for_time(now_ns);
  tell_conditions();
  return changed;
}

void StreamIntake::wait(std::chrono::nanoseconds timeout) {
  if (!held_.empty()) return;
  if (listeners_.empty()) return;
  // Several listeners take turns; each gets a share of the time.
  for (const auto& listener : listeners_) listener->wait(timeout / static_cast<int64_t>(listeners_.size()));
}

void StreamIntake::play(uint64_t epoch, bool interpolate, std::optional<int64_t> delay_ns) {
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
      poses_.show_newest(stream.id, static_cast<int64_t>(monotonic_now_ns()));
    }
  }
}

// Clocks of other machines are asked often at first, then often enough for their drift.
void StreamIntake::ask_for_time(int64_t now_ns) {
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

// A simulator that pauses is late soon, and nobody needs to hear of it; lost and back again are news.
void StreamIntake::tell_conditions() {
  for (auto& [peer, stream] : stream_of_peer_) {
    const bool is_lost = poses_.streams()[stream.id].condition == state::Condition::lost;
    if (std::exchange(stream.lost_told, is_lost) == is_lost) continue;
    note("stream \"" + stream.name +
         (is_lost ? "\" sends no frames; the last one is held" : "\" sends frames again"));
  }
}

bool StreamIntake::handle(Peer peer, transport::LinkEvent::Kind kind, std::span<const std::byte> message,
                          std::string_view text, int64_t received_ns) {
  using Kind = transport::LinkEvent::Kind;
  switch (kind) {
    case Kind::connected:
      return false;
    case Kind::note:
      note(std::string(text));
      return false;
    case Kind::disconnected: {
      end_stream(peer, std::string(text));
      rejected_of_peer_.erase(peer);
      budget_of_peer_.erase(peer);
      return false;
    }
    case Kind::pose:
    case Kind::control:
      break;
  }

  Result<wire::Message> decoded = decoder_.decode(message);
  if (!decoded) {
    reject(peer, Refusal::unreadable, decoded.error().message);
    if (const auto& request = decoder_.refused_request(); request && request->id != 0) {
      tell_refused(peer,
                   {request->epoch, request->id, wire::ImageRefusal::bad_request, decoded.error().message});
      return false;
    }
    // What cannot be read may have been a description: silence would leave its adapter guessing.
    if (kind == Kind::control) {
      wire::Welcome welcome;
      welcome.status = wire::WelcomeStatus::bad_description;
      welcome.renderer_name = renderer_name();
      welcome.message = decoded.error().message;
      reply(peer, wire::encode(welcome));
    }
    return false;
  }
  if (const auto* frame = std::get_if<wire::PoseFrameView>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    if (stream == stream_of_peer_.end()) {
      reject(peer, Refusal::before_description, "pose frame before a description");
      return false;
    }
    const int64_t came_ns = received_ns != 0 ? received_ns : static_cast<int64_t>(monotonic_now_ns());
    state::ClockOffset& clock = stream->second.clock;
    clock.on_frame(frame->header.publish_time_ns, came_ns);
    return poses_.push(stream->second.id, *frame, clock.soonest_ns(frame->header.publish_time_ns), came_ns);
  }
  if (const auto* description = std::get_if<wire::StreamDescription>(&*decoded)) {
    describe(peer, *description);
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
    ask_for_image(peer, *request);
    return false;
  }
  if (const auto* ping = std::get_if<wire::Ping>(&*decoded)) {
    reply(peer, wire::encode(wire::Pong{ping->id, ping->sender_time_ns, monotonic_now_ns()}));
    return false;
  }
  if (std::holds_alternative<wire::Goodbye>(*decoded)) {
    end_stream(peer, "it said goodbye");
    return false;  // in lockstep, images are of pose frames alone
  }
  if (const auto* pong = std::get_if<wire::Pong>(&*decoded)) {
    const auto stream = stream_of_peer_.find(peer);
    const bool asked = stream != stream_of_peer_.end() && pong->id != 0 && pong->id <= stream->second.pings;
    const int64_t came_ns = received_ns != 0 ? received_ns : static_cast<int64_t>(monotonic_now_ns());
    if (asked && pong->ping_sender_time_ns <= static_cast<uint64_t>(came_ns))
      stream->second.clock.on_pong(static_cast<int64_t>(pong->ping_sender_time_ns), pong->answer_time_ns,
                                   came_ns);
    return false;
  }
  if (std::holds_alternative<wire::UnknownMessage>(*decoded)) return false;  // of a later minor version
  reject(peer, Refusal::wrong_way, "a message that only renderers send");
  return false;
}

void StreamIntake::describe(Peer peer, const wire::StreamDescription& description) {
  const std::string name = description.adapter_name.empty() ? "an adapter" : description.adapter_name;
  if (description.protocol_major != wire::kProtocolMajor) {
    ++refusals_[static_cast<size_t>(Refusal::version)];
    wire::Welcome refusal;
    refusal.status = wire::WelcomeStatus::version_mismatch;
    refusal.epoch = description.epoch;
    refusal.renderer_name = renderer_name();
    refusal.message = "this renderer speaks protocol " + std::to_string(wire::kProtocolMajor) + "." +
                      std::to_string(wire::kProtocolMinor) + ", the adapter " +
                      std::to_string(description.protocol_major) + "." +
                      std::to_string(description.protocol_minor) + "; update the older one";
    note(name + " was refused: " + refusal.message);
    end_stream(peer, "it goes on in another version of the protocol");
    reply(peer, wire::encode(refusal));
    return;
  }

  const auto known = stream_of_peer_.find(peer);
  if (known != stream_of_peer_.end() && known->second.epoch == description.epoch) {  // repeated
    welcome(peer, known->second);
    return;
  }
  if (known != stream_of_peer_.end()) end_stream(peer, "it began anew");
  // An epoch is one run of one stream: whoever has it on another connection has lost that one without a word.
  const auto ghost = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(),
                                  [&](const auto& entry) { return entry.second.epoch == description.epoch; });
  if (ghost != stream_of_peer_.end()) end_stream(Peer(ghost->first), "it came back over another connection");
  const state::StreamId id = poses_.add_stream(description, budget_of(peer));
  PeerStream& stream = stream_of_peer_[peer] = {};
  stream.id = id;
  stream.epoch = description.epoch;
  stream.name = name;
  stream.asker = ++last_asker_;
  peer_of_asker_.emplace(stream.asker, peer);
  const std::string& their_boot = description.clock.boot_id;
  if (their_boot == boot_id()) stream.clock.same_clock();
  stream.interpolated =
      !lockstep_ &&
      (play_.mode == PlayOptions::Mode::interpolate ||
       (play_.mode == PlayOptions::Mode::by_clock && !their_boot.empty() && their_boot != boot_id()));
  stream.delay_ns = play_.delay_ns;
  if (stream.interpolated) poses_.interpolate(id, stream.delay_ns);
  had_streams_ = true;

  const state::Stream& bound = poses_.streams()[id];
  std::string accepted =
      "stream \"" + name + "\" with " + std::to_string(description.node_names.size()) + " nodes accepted";
  if (!bound.unmatched_names.empty())
    accepted += "; no scene node is called " + list_names(bound.unmatched_names);
  if (!bound.conflicting_names.empty())
    accepted += "; another stream drives " + list_names(bound.conflicting_names);
  note(std::move(accepted));
  welcome(peer, stream);
  tell_contests();
}

// Whoever drives a node that another stream asks for hears of it too: either of them may be the mistake.
void StreamIntake::tell_contests() {
  for (auto& [peer, stream] : stream_of_peer_) {
    const std::vector<std::string>& contested = poses_.streams()[stream.id].contested_names;
    if (contested == stream.contests_told) continue;
    stream.contests_told = contested;
    wire::Status status;
    status.epoch = stream.epoch;
    status.contested_names = first_names(contested);
    status.message = contested.empty() ? "no other stream asks for its nodes any more"
                                       : "another stream asks for nodes that this one drives and keeps";
    reply(peer, wire::encode(status));
  }
}

// The names travel as lists: the adapter's library makes a sentence of them.
void StreamIntake::welcome(Peer peer, PeerStream& stream) {
  const state::Stream& bound = poses_.streams()[stream.id];
  wire::Welcome answer;
  answer.epoch = stream.epoch;
  answer.renderer_name = renderer_name();
  answer.message = "accepted";
  answer.unmatched_names = first_names(bound.unmatched_names);
  answer.conflicting_names = first_names(bound.conflicting_names);
  stream.conflicts_told = bound.conflicting_names;
  stream.unmatched_told = bound.unmatched_names;
  reply(peer, wire::encode(answer));
}

void StreamIntake::end_stream(Peer peer, const std::string& reason) {
  const auto ended = stream_of_peer_.find(peer);
  if (ended == stream_of_peer_.end()) return;
  poses_.remove_stream(ended->second.id);
  note("stream \"" + ended->second.name + "\" ended: " + reason);
  if (images_) images_->forget(ended->second.asker);
  peer_of_asker_.erase(ended->second.asker);
  stream_of_peer_.erase(ended);
  // Its nodes may have passed to streams that were told they could not have them.
  for (auto& [other, stream] : stream_of_peer_) {
    if (poses_.streams()[stream.id].conflicting_names == stream.conflicts_told) continue;
    note("stream \"" + stream.name + "\" now drives nodes that another stream has given back");
    welcome(other, stream);
  }
  tell_contests();
}

void StreamIntake::tell_bindings() {
  for (auto& [peer, stream] : stream_of_peer_) {
    const state::Stream& bound = poses_.streams()[stream.id];
    if (bound.unmatched_names == stream.unmatched_told && bound.conflicting_names == stream.conflicts_told)
      continue;
    note("stream \"" + stream.name + "\" drives " +
         std::to_string(bound.scene_node_of_pose.size() - bound.unmatched_names.size() -
                        bound.conflicting_names.size()) +
         " nodes of the scene as it is now");
    welcome(peer, stream);
  }
  tell_contests();
}

void StreamIntake::acknowledge(const std::vector<state::FrameTag>& shown) {
  for (const state::FrameTag& tag : shown) {
    for (auto& [peer, stream] : stream_of_peer_) {
      // Once for each frame, not for each image of it: a paused simulator is not to be flooded.
      if (stream.epoch != tag.epoch || stream.acked_sequence >= tag.sequence) continue;
      stream.acked_sequence = tag.sequence;
      reply(peer, wire::encode(wire::Ack{tag.epoch, tag.sequence}));
    }
  }
}

void StreamIntake::reply(Peer peer, const wire::Bytes& message) {
  listeners_[peer.first]->send(peer.second, message);
}

// The first fault of a peer is told, the others are counted: a broken adapter at 1 kHz must not fill the
// terminal.
void StreamIntake::reject(Peer peer, Refusal refusal, const std::string& reason) {
  ++refusals_[static_cast<size_t>(refusal)];
  if (rejected_of_peer_[peer]++ == 0) {
    note("dropped a message from " + listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second) +
         ": " + reason);
  }
}

// A peer that describes and leaves a thousand times a second must not fill the terminal either.
void StreamIntake::note(std::string text) {
  constexpr uint32_t kNotesPerSecond = 20;
  const auto now = std::chrono::steady_clock::now();
  if (now - notes_since_ >= std::chrono::seconds(1)) {
    if (notes_left_out_) notes_.push_back("and " + std::to_string(notes_left_out_) + " more such events");
    notes_since_ = now;
    notes_this_second_ = notes_left_out_ = 0;
  }
  if (notes_this_second_++ < kNotesPerSecond) {
    notes_.push_back(std::move(text));
  } else {
    ++notes_left_out_;
  }
}

uint64_t StreamIntake::rejected_messages() const {
  return std::accumulate(refusals_.begin(), refusals_.end(), uint64_t{0});
}

std::vector<StreamIntake::LinkReport> StreamIntake::links() const {
  std::vector<LinkReport> links;
  for (const auto& listener : listeners_) links.push_back({listener->uri(), listener->stats()});
  return links;
}

std::vector<StreamIntake::Report> StreamIntake::report() const {
  std::vector<Report> streams;
  for (const auto& [peer, stream] : stream_of_peer_)
    streams.push_back({stream.id, listeners_[peer.first]->uri(), stream.clock.source()});
  return streams;
}

std::optional<int64_t> StreamIntake::published_ns(uint64_t epoch, uint64_t publish_time_ns) const {
  for (const auto& [peer, stream] : stream_of_peer_) {
    if (stream.epoch != epoch || stream.clock.source() == state::ClockOffset::Source::none) continue;
    return stream.clock.local_ns(publish_time_ns);
  }
  return {};
}

std::vector<std::string> StreamIntake::take_notes() {
  return std::exchange(notes_, {});
}

}  // namespace fire3dv::app
