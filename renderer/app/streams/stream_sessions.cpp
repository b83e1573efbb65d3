// Life cycle of streams in the receiver: binds and answers descriptions, reports binding changes, and returns
// reconnected streams to their slots. If two connections publish one stream, the older one keeps it while it
// is alive.
#include <algorithm>
#include <fstream>

#include "protocol/wire/encode.h"
#include "renderer/app/streams/stream_receiver.h"
#include "renderer/app/version.h"

namespace fire3dv::app {
namespace {

constexpr size_t kNamesInNote = 5;
constexpr size_t kMaxNameBytes = 1024 + 8;  // per name, including list overhead
// Per list of a Welcome or Status: a reply must fit every link's back channel.
constexpr size_t kNameBytesInAnswer = 16 << 10;
// Grace time of the slot of a stream that lost its link or sent a new description.
constexpr int64_t kGraceNs = 5'000'000'000;
// A connection gives way to another one of its stream after this silence, if it does not answer a ping.
constexpr int64_t kSilentNs = 2'000'000'000, kAnswerNs = 500'000'000, kRefusedNs = 1'000'000'000;
constexpr uint32_t kReportsPerSecond = 20;  // of changed bindings, per stream

std::string list_names(const state::PoseState& poses, state::StreamId id, const state::IndexSet& indices) {
  const std::vector<std::string> names = poses.names_at(id, indices, kNamesInNote * kMaxNameBytes);
  const size_t shown = std::min(names.size(), kNamesInNote);
  std::string text;
  for (size_t i = 0; i < shown; ++i) text += (i ? ", \"" : "\"") + names[i] + "\"";
  if (indices.size() > shown) text += " and " + std::to_string(indices.size() - shown) + " more";
  return text;
}

// Bytes of a description's names and offsets, and of their bindings to nodes.
uint64_t description_memory(const wire::StreamDescription& description) {
  constexpr uint64_t kBytesPerName = sizeof(std::string) + 2 * sizeof(uint32_t) + 16;
  uint64_t bytes = description.node_names.size() * kBytesPerName +
                   description.body_from_node.size() * sizeof(wire::Affine3x4);
  for (const std::string& name : description.node_names) bytes += name.size();
  return bytes;
}

std::string name_of(const wire::StreamDescription& description) {
  return description.adapter_name.empty() ? "an adapter" : description.adapter_name;
}

std::string renderer_name() {
  return std::string("fire3dv ") + kVersion;
}

// Never empty: a publisher with an unknown boot id must not count as local.
const std::string& boot_id() {
  static const std::string id = [] {
    std::string text;
    std::ifstream("/proc/sys/kernel/random/boot_id") >> text;
    return text.empty() ? "unknown" : text;
  }();
  return id;
}

}  // namespace

bool StreamReceiver::describe(Peer peer, const wire::StreamDescription& description) {
  if (description.protocol_major != wire::kProtocolMajor) {
    refuse_version(peer, description);
    return true;
  }
  const auto known = stream_of_peer_.find(peer);
  if (known != stream_of_peer_.end() && known->second.epoch == description.epoch) {  // repeated
    welcome(peer, known->second);
    return true;
  }
  // An epoch identifies one run of one stream. A second connection with it has either lost the first one
  // silently, or is an impostor: epochs are not secret (multicast and recordings expose them). Peers of
  // another listener, which may require no key, therefore never take a stream over and get a stream of their
  // own.
  const auto older = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(), [&](const auto& entry) {
    return entry.second.epoch == description.epoch && entry.first != peer && entry.first.first == peer.first;
  });
  if (older == stream_of_peer_.end()) {
    if (known != stream_of_peer_.end())
      accept(peer, description, suspend_stream(peer, "it began anew", false));
    else
      begin_stream(peer, description);
    return true;
  }
  const PeerState& state = peers_.at(peer);
  if (state.refused_epoch == description.epoch && now_ns_ - state.refused_ns < kRefusedNs) {
    refuse_description(peer, description.epoch, wire::WelcomeStatus::refused,
                       "another connection publishes this run of the stream and is alive; end one of them");
    return true;
  }
  begin_conflict(peer, description, older->first);
  return false;
}

void StreamReceiver::refuse_version(Peer peer, const wire::StreamDescription& description) {
  ++refusals_[static_cast<size_t>(Refusal::version)];
  const std::string reason = "this renderer speaks protocol " + std::to_string(wire::kProtocolMajor) + "." +
                             std::to_string(wire::kProtocolMinor) + ", the adapter " +
                             std::to_string(description.protocol_major) + "." +
                             std::to_string(description.protocol_minor) + "; update the older one";
  note(name_of(description) + " was refused: " + reason);
  end_stream(peer, "it goes on in another version of the protocol");
  refuse_description(peer, description.epoch, wire::WelcomeStatus::version_mismatch, reason);
}

void StreamReceiver::refuse_description(Peer peer, uint64_t epoch, wire::WelcomeStatus status,
                                        const std::string& reason) {
  wire::Welcome welcome;
  welcome.status = status;
  welcome.epoch = epoch;
  welcome.renderer_name = renderer_name();
  welcome.message = reason;
  reply(peer, wire::encode(welcome));
}

void StreamReceiver::accept(Peer peer, const wire::StreamDescription& description, uint64_t place) {
  const std::string name = name_of(description);
  const std::shared_ptr<PeerBudget> budget = budget_of(peer);
  budget->set_name(name);
  Result<BudgetCharge> bytes =
      BudgetCharge::take(budget, Resource::description_bytes, description_memory(description));
  Result<BudgetCharge> names =
      bytes ? BudgetCharge::take(budget, Resource::names, description.node_names.size())
            : Result<BudgetCharge>(bytes.error());
  if (!names) {
    note("stream \"" + name + "\" was refused: " + names.error().message);
    return refuse_description(peer, description.epoch, wire::WelcomeStatus::bad_description,
                              names.error().message);
  }
  std::erase_if(left_, [place](const Left& left) { return left.place == place && left.borrower_epoch == 0; });
  const state::StreamId id = poses_.add_stream(description, budget, place);
  listeners_[peer.first]->accept(peer.second);
  PeerStream& stream = stream_of_peer_[peer] = {};
  stream.id = id;
  stream.epoch = description.epoch;
  stream.name = name;
  stream.description_bytes = std::move(*bytes);
  stream.names = std::move(*names);
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
    accepted += "; no scene node is called " + list_names(poses_, id, bound.unmatched_names);
  if (!bound.conflicting_names.empty())
    accepted += "; another stream drives " + list_names(poses_, id, bound.conflicting_names);
  note(std::move(accepted));
  welcome(peer, stream);
}

// The names are sent as lists, which the adapter's library formats.
void StreamReceiver::welcome(Peer peer, PeerStream& stream) {
  const state::Stream& bound = poses_.streams()[stream.id];
  wire::Welcome answer;
  answer.epoch = stream.epoch;
  answer.renderer_name = renderer_name();
  answer.message = "accepted";
  answer.unmatched_names = poses_.names_at(stream.id, bound.unmatched_names, kNameBytesInAnswer);
  answer.conflicting_names = poses_.names_at(stream.id, bound.conflicting_names, kNameBytesInAnswer);
  stream.conflicts_told = bound.conflicting_names.revision();
  stream.unmatched_told = bound.unmatched_names.revision();
  reply(peer, wire::encode(answer));
}

void StreamReceiver::send_status(Peer peer, PeerStream& stream, const std::string& message) {
  const state::IndexSet& contested = poses_.streams()[stream.id].contested_names;
  stream.contests_told = contested.revision();
  wire::Status status;
  status.epoch = stream.epoch;
  status.contested_names = poses_.names_at(stream.id, contested, kNameBytesInAnswer);
  status.message = message;
  reply(peer, wire::encode(status));
}

void StreamReceiver::notify_bindings() {
  now_ns_ = clock_();
  report_bindings(true);
}

// Once per poll: reports changed bindings to their streams, and contested nodes to the streams that drive
// them, since either side may be wrong.
void StreamReceiver::report_bindings(bool scene_is_new) {
  for (auto& [peer, stream] : stream_of_peer_) {
    const state::Stream& bound = poses_.streams()[stream.id];
    const bool rebound = bound.unmatched_names.revision() != stream.unmatched_told ||
                         bound.conflicting_names.revision() != stream.conflicts_told;
    const bool contested = bound.contested_names.revision() != stream.contests_told;
    if ((!rebound && !contested) || !stream.reports.take(now_ns_, kReportsPerSecond)) continue;
    handled_peer_ = peer;
    if (rebound) {
      note("stream \"" + stream.name + "\"" +
           (scene_is_new ? " drives " +
                               std::to_string(bound.scene_node_of_pose.size() - bound.unmatched_names.size() -
                                              bound.conflicting_names.size()) +
                               " nodes of the scene as it is now"
                         : " now drives nodes that another stream has given back"));
      welcome(peer, stream);
    }
    if (contested)
      send_status(peer, stream,
                  bound.contested_names.empty()
                      ? "no other stream asks for its nodes any more"
                      : "another stream asks for nodes that this one drives and keeps");
  }
  handled_peer_.reset();
}

void StreamReceiver::report_refusals() {
  for (const state::BudgetRefusal& refusal : poses_.take_refusals()) {
    const auto stream = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(),
                                     [&](const auto& entry) { return entry.second.id == refusal.stream; });
    if (stream == stream_of_peer_.end()) continue;
    uint32_t& told = peers_[stream->first].refusals_told;
    const uint32_t bit = 1u << static_cast<uint32_t>(refusal.resource);
    if ((std::exchange(told, told | bit) & bit) != 0) continue;
    handled_peer_ = stream->first;
    note("stream \"" + stream->second.name + "\" is refused a part of what it sends: " + refusal.message);
  }
  handled_peer_.reset();
}

void StreamReceiver::drop_stream(Peer peer, const std::string& reason) {
  const auto ended = stream_of_peer_.find(peer);
  note("stream \"" + ended->second.name + "\" ended: " + reason);
  if (images_) images_->forget(ended->second.asker);
  peer_of_asker_.erase(ended->second.asker);
  stream_of_peer_.erase(ended);
}

void StreamReceiver::end_stream(Peer peer, const std::string& reason) {
  const auto ended = stream_of_peer_.find(peer);
  if (ended == stream_of_peer_.end()) return;
  poses_.remove_stream(ended->second.id);
  drop_stream(peer, reason);
}

uint64_t StreamReceiver::suspend_stream(Peer peer, const std::string& reason, bool lends) {
  const auto ended = stream_of_peer_.find(peer);
  if (ended == stream_of_peer_.end()) return 0;
  const int64_t until_ns = now_ns_ + kGraceNs;
  const uint64_t place = poses_.suspend_stream(ended->second.id, until_ns);
  std::erase_if(left_, [this](const Left& left) { return left.until_ns <= now_ns_; });
  left_.push_back({peer.first, ended->second.epoch, ended->second.name, place, until_ns});
  if (left_.size() > state::PoseState::kMaxPlaces)
    left_.erase(std::max_element(left_.begin(), left_.end(),
                                 [](const Left& a, const Left& b) { return a.place < b.place; }));
  drop_stream(peer, reason);
  if (lends && !left_.empty() && left_.back().place == place) lend_nodes(left_.back());
  return place;
}

// Reconnection: the epoch identifies the same run; for shared memory the segment does, which belongs to one
// user and one publisher. A restarted publisher matches by name only: it borrows the slot, and returns it if
// the earlier run reconnects in time.
void StreamReceiver::begin_stream(Peer peer, const wire::StreamDescription& description) {
  const auto same = std::find_if(left_.begin(), left_.end(), [&](const Left& each) {
    return each.listener == peer.first && each.until_ns > now_ns_ && each.epoch == description.epoch &&
           each.name == name_of(description);
  });
  if (same == left_.end()) return accept(peer, description, borrow_place(peer, description));
  const Left left = *same;
  left_.erase(same);
  if (left.borrower_epoch == 0) return accept(peer, description, left.place);
  const auto borrower = stream_of_peer_.find(left.borrower);
  const bool has_it = borrower != stream_of_peer_.end() && borrower->second.epoch == left.borrower_epoch;
  if (!has_it)
    return accept(peer, description, left.lent_nodes ? left.place : borrow_place(peer, description));
  const std::string reason = "the stream whose place it had has returned";
  refuse_description(left.borrower, left.borrower_epoch, wire::WelcomeStatus::refused, reason);
  if (!left.lent_nodes) return accept(peer, description, suspend_stream(left.borrower, reason, false));
  accept(peer, description, left.place);
  end_stream(left.borrower, reason);  // its nodes go to the oldest stream that waits for them
}

uint64_t StreamReceiver::borrow_place(Peer peer, const wire::StreamDescription& description) {
  const bool has_one_publisher = listeners_[peer.first]->uri().starts_with("shm://");
  const auto left = std::find_if(left_.begin(), left_.end(), [&](const Left& each) {
    return each.listener == peer.first && each.until_ns > now_ns_ && each.borrower_epoch == 0 &&
           (has_one_publisher || each.name == name_of(description));
  });
  if (left == left_.end()) return 0;
  left->borrower = peer;
  left->borrower_epoch = description.epoch;
  return left->place;
}

// Same as borrow_place(), for a stream that connected before the loss was detected.
void StreamReceiver::lend_nodes(Left& left) {
  const auto next = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(), [&](const auto& entry) {
    return entry.first.first == left.listener && entry.second.name == left.name;
  });
  if (next == stream_of_peer_.end()) return;
  left.borrower = next->first;
  left.borrower_epoch = next->second.epoch;
  left.lent_nodes = true;
  poses_.lend_place(left.place, next->second.id);
}

// The older connection may be dead without notice: pings it, and takes its stream if it stays silent.
void StreamReceiver::begin_conflict(Peer peer, const wire::StreamDescription& description, Peer older) {
  PeerStream& stream = stream_of_peer_.at(older);
  const bool may_be_same = older.first == peer.first && stream.name == name_of(description);
  const int64_t decide_ns = std::max(peers_[older].heard_ns + kSilentNs, now_ns_ + kAnswerNs);
  peers_.at(peer).contest = EpochConflict{older, description.epoch, may_be_same, now_ns_, decide_ns};
  send_status(older, stream,
              "another connection publishes this run of the stream; this one keeps it while it lives");
  reply(older, wire::encode(wire::Ping{UINT64_MAX, static_cast<uint64_t>(now_ns_)}));
}

void StreamReceiver::resolve_conflicts() {
  for (auto& [peer, state] : peers_) {
    if (!state.contest) continue;
    const EpochConflict contest = *state.contest;
    const auto older = stream_of_peer_.find(contest.older);
    const bool ended = older == stream_of_peer_.end() || older->second.epoch != contest.epoch;
    const int64_t heard_ns = ended ? 0 : peers_[contest.older].heard_ns;
    if (!ended && heard_ns <= contest.asked_ns && now_ns_ < contest.decide_ns) continue;
    state.contest.reset();
    if (ended) continue;
    if (heard_ns > contest.asked_ns || !contest.may_be_same) {
      state.refused_epoch = contest.epoch;
      state.refused_ns = now_ns_;
      handled_peer_ = peer;
      note("stream \"" + older->second.name + "\": another connection (" + listeners_[peer.first]->uri() +
           " peer " + std::to_string(peer.second) + ") that publishes the same run was refused");
    } else {
      suspend_stream(contest.older, "it came back over another connection", false);
    }
  }
  handled_peer_.reset();
}

}  // namespace fire3dv::app
