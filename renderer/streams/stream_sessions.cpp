// Life cycle of streams in the receiver: binds and answers descriptions, reports binding changes, and returns
// reconnected streams to their slots. If two connections publish one stream, the older one keeps it while it
// is alive.
#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "protocol/wire/encode.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {
namespace {

constexpr size_t kNamesInLog = 5;
constexpr size_t kMaxStreamNameBytes = 1024 + 8;  // per name, including list overhead
// Per list of a Welcome or Status: a reply must fit every link's back channel.
constexpr size_t kNameBytesInReply = 16 << 10;
// Grace time of the slot of a stream that lost its link or sent a new description.
constexpr int64_t kGraceNs = 5'000'000'000;
// A connection gives way to another one of its stream after this silence, if it does not answer a ping.
constexpr int64_t kSilentNs = 2'000'000'000, kAnswerNs = 500'000'000, kRefusedNs = 1'000'000'000;
constexpr uint32_t kReportsPerSecond = 20;  // of changed bindings, per stream

std::string list_names(const state::PoseState& poses, state::StreamId id, const state::IndexSet& indices) {
  const std::vector<std::string> names = poses.names_at(id, indices, kNamesInLog * kMaxStreamNameBytes);
  const size_t shown = std::min(names.size(), kNamesInLog);
  std::string text;
  for (size_t i = 0; i < shown; ++i) text += (i ? ", \"" : "\"") + names[i] + "\"";
  if (indices.size() > shown) text += " and " + std::to_string(indices.size() - shown) + " more";
  return text;
}

// Example: ": stream \"A\"", which drives the first of the nodes. Nodes that are reserved for a stream that
// may return have no driver.
std::string first_driver(const state::PoseState& poses, const wire::StreamDescription& description,
                         const state::IndexSet& indices) {
  std::string text;
  indices.visit([&](uint32_t index) {
    const uint32_t node = poses.names().find(description.node_names[index]);
    const auto drives = [node](const state::Stream& stream) {
      return stream.active &&
             std::ranges::find(stream.scene_node_of_pose, node) != stream.scene_node_of_pose.end();
    };
    const auto driver = std::ranges::find_if(poses.streams(), drives);
    if (node != scene::kNone && driver != poses.streams().end()) text = ": stream \"" + driver->name + "\"";
    return false;
  });
  return text;
}

// Names that the stream could use.
std::string list_scene_nodes(const scene::Scene& scene) {
  constexpr size_t kNames = 3;
  std::vector<std::string> names;
  for (const scene::Node& node : scene.nodes) {
    if (node.name.empty() || node.name.size() > kMaxStreamNameBytes) continue;
    names.push_back(quote(node.name));
    if (names.size() == kNames) break;
  }
  if (names.empty()) return "; no node of the scene has a name";
  std::string text = "; the scene has";
  for (size_t i = 0; i < names.size(); ++i) text += (i ? ", " : " ") + names[i];
  return text;
}

// True if the path has all parts of the name, in this order, and ends with the last one.
bool has_parts(std::string_view path, std::string_view name) {
  const auto last_part = [](std::string_view& rest) {
    const size_t slash = rest.rfind('/');
    const std::string_view part = slash == rest.npos ? rest : rest.substr(slash + 1);
    rest = slash == rest.npos ? std::string_view() : rest.substr(0, slash);
    return part;
  };
  if (last_part(path) != last_part(name)) return false;
  while (!name.empty()) {
    const std::string_view part = last_part(name);
    bool is_found = false;
    while (!is_found && !path.empty()) is_found = last_part(path) == part;
    if (!is_found) return false;
  }
  return true;
}

// Paths of nodes that unmatched names may mean, such as "pole" is "env0/cart/pole" or "env1/cart/pole".
// Empty: there are none.
std::string list_paths(const scene::Scene& scene, const std::vector<std::string>& names) {
  constexpr size_t kNames = 3, kPaths = 2;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kNames); ++i) {
    const std::string& name = names[i];
    size_t count = 0;
    std::string paths;
    for (const scene::Node& node : scene.nodes) {
      if (!has_parts(node.path, name) || ++count > kPaths) continue;
      paths += (count == 1 ? "" : " or ") + quote(node.path);
    }
    if (count == 0) continue;
    text += (text.empty() ? "" : ", ") + quote(name) + " is " + paths;
    if (count > kPaths) text += " or " + std::to_string(count - kPaths) + " others";
  }
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
  return "fire3dv " FIRE3DV_VERSION;
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

bool StreamReceiver::handle_description(Peer peer, const wire::StreamDescription& description) {
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
    if (known == stream_of_peer_.end() && !admit(peer, description)) return false;
    if (known != stream_of_peer_.end())
      accept_stream(peer, description, suspend_stream(peer, "it began anew", false));
    else
      begin_stream(peer, description);
    return true;
  }
  const PeerState& state = peers_.at(peer);
  if (state.refused_epoch == description.epoch && clock_.now_ns - state.refused_ns < kRefusedNs) {
    refuse_description(peer, description.epoch, wire::WelcomeStatus::refused,
                       "another connection publishes this run of the stream and is alive; end one of them");
    return true;
  }
  begin_conflict(peer, description, older->first);
  return false;
}

// Each new stream binds nodes and may replace the scene, so that those of one host are paced while other
// streams are shown. Returns false if the description waits.
bool StreamReceiver::admit(Peer peer, const wire::StreamDescription& description) {
  const PeerState& state = peers_.at(peer);
  scheduler_.end_wait(peer);
  if (lockstep_ || stream_of_peer_.empty()) return true;
  const std::optional<int64_t> until_ns = admission_.wait_until_ns(state.host, clock_.now_ns);
  if (!until_ns) return true;
  scheduler_.await_stream(peer, *until_ns);
  if (admission_.take_notice(state.host, clock_.now_ns))
    log(warning("stream \"" + name_of(description) + "\" waits: " + state.host + " begins more than " +
                std::to_string(static_cast<int>(StreamAdmission::kPerSecond)) +
                " streams a second, and others are shown; keep its connections open"));
  return false;
}

void StreamReceiver::refuse_version(Peer peer, const wire::StreamDescription& description) {
  ++refusals_[static_cast<size_t>(Refusal::version)];
  const std::string reason = "this renderer speaks protocol " + std::to_string(wire::kProtocolMajor) + "." +
                             std::to_string(wire::kProtocolMinor) + ", the adapter " +
                             std::to_string(description.protocol_major) + "." +
                             std::to_string(description.protocol_minor) + "; update the older one";
  log(name_of(description) + " was refused: " + reason);
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

void StreamReceiver::accept_stream(Peer peer, const wire::StreamDescription& description,
                                   uint64_t reservation) {
  const std::string name = name_of(description);
  const std::shared_ptr<PeerBudget> budget = budget_of(peer);
  budget->set_name(name);
  Result<BudgetCharge> bytes =
      BudgetCharge::take(budget, Resource::description_bytes, description_memory(description));
  Result<BudgetCharge> names =
      bytes ? BudgetCharge::take(budget, Resource::names, description.node_names.size())
            : Result<BudgetCharge>(bytes.error());
  if (!names) {
    log(warning("stream \"" + name + "\" was refused: " + names.error().message));
    return refuse_description(peer, description.epoch, wire::WelcomeStatus::bad_description,
                              names.error().message);
  }
  std::erase_if(suspended_, [reservation](const SuspendedStream& suspended) {
    return suspended.reservation == reservation && suspended.successor_epoch == 0;
  });
  const state::StreamId id = poses_.add_stream(description, budget, reservation);
  listeners_[peer.first]->accept(peer.second);
  PeerStream& stream = stream_of_peer_[peer] = {};
  stream.id = id;
  stream.epoch = description.epoch;
  stream.name = name;
  stream.description_bytes = std::move(*bytes);
  stream.names = std::move(*names);
  stream.requester = images_.add({listeners_[peer.first].get(), peer.second, id, stream.epoch, name});
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
      "stream \"" + name + "\" with " + counted(description.node_names.size(), "node") + " accepted";
  if (!bound.unmatched_names.empty())
    accepted += "; no scene node is called " + list_names(poses_, id, bound.unmatched_names);
  if (!bound.conflicting_names.empty())
    accepted += "; another stream drives " + list_names(poses_, id, bound.conflicting_names) +
                first_driver(poses_, description, bound.conflicting_names);
  log(bound.conflicting_names.empty() ? accepted : warning(accepted));
  welcome(peer, stream);
}

// The names are sent as lists, which the adapter's library formats.
void StreamReceiver::welcome(Peer peer, PeerStream& stream) {
  const state::Stream& bound = poses_.streams()[stream.id];
  wire::Welcome answer;
  answer.epoch = stream.epoch;
  answer.renderer_name = renderer_name();
  answer.message = "accepted";
  answer.unmatched_names = poses_.names_at(stream.id, bound.unmatched_names, kNameBytesInReply);
  answer.conflicting_names = poses_.names_at(stream.id, bound.conflicting_names, kNameBytesInReply);
  stream.reported_conflicting = bound.conflicting_names.revision();
  stream.reported_unmatched = bound.unmatched_names.revision();
  reply(peer, wire::encode(answer));
}

void StreamReceiver::send_status(Peer peer, PeerStream& stream, const std::string& message) {
  const state::IndexSet& contested = poses_.streams()[stream.id].contested_names;
  stream.reported_contested = contested.revision();
  wire::Status status;
  status.epoch = stream.epoch;
  status.contested_names = poses_.names_at(stream.id, contested, kNameBytesInReply);
  status.message = message;
  reply(peer, wire::encode(status));
}

void StreamReceiver::notify_bindings() {
  clock_.update();
  report_bindings(true);
}

// Once per poll: reports changed bindings to their streams, and contested nodes to the streams that drive
// them, since either side may be wrong.
void StreamReceiver::report_bindings(bool scene_is_new) {
  for (auto& [peer, stream] : stream_of_peer_) {
    const state::Stream& bound = poses_.streams()[stream.id];
    const bool rebound = bound.unmatched_names.revision() != stream.reported_unmatched ||
                         bound.conflicting_names.revision() != stream.reported_conflicting;
    const bool contested = bound.contested_names.revision() != stream.reported_contested;
    if ((!rebound && !contested) || !stream.reports.take(clock_.now_ns, kReportsPerSecond)) continue;
    handled_peer_ = peer;
    if (rebound) {
      log("stream \"" + stream.name + "\"" +
          (scene_is_new ? " drives " +
                              counted(bound.scene_node_of_pose.size() - bound.unmatched_names.size() -
                                          bound.conflicting_names.size(),
                                      "node") +
                              " of the new scene"
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

// One message: adapters show one after the other.
void StreamReceiver::send_advice(Peer peer, PeerStream& stream) {
  std::string text;
  for (const std::string& advice : std::exchange(stream.advice, {}))
    text += (text.empty() ? "this stream " : "; it ") + advice;
  send_status(peer, stream, text);
}

void StreamReceiver::report_ineffective_edit(state::StreamId id, const std::string& reason) {
  send_advice_to(id, "has an edit without effect: " + reason);
}

void StreamReceiver::report_drawing(state::StreamId id, const std::string& text) {
  send_advice_to(id, "is drawn otherwise than before: " + text);
}

void StreamReceiver::send_advice_to(state::StreamId id, std::string&& advice) {
  const auto found =
      std::ranges::find_if(stream_of_peer_, [id](const auto& entry) { return entry.second.id == id; });
  if (found == stream_of_peer_.end()) return;
  handled_peer_ = found->first;
  found->second.advice.push_back(std::move(advice));
  send_advice(found->first, found->second);
  handled_peer_.reset();
}

// Once for each description, with its first shown frame.
void StreamReceiver::report_poses() {
  for (auto& [peer, stream] : stream_of_peer_) {
    if (poses_.streams()[stream.id].header.sequence == 0 || std::exchange(stream.checked_poses, true))
      continue;
    handled_peer_ = peer;
    const auto report = [&](const std::string& text) {
      log(warning("stream \"" + stream.name + "\" " + text));
      stream.advice.push_back(text);
    };
    // Not earlier: a stream may add its nodes after it has described itself.
    const state::Stream& bound = poses_.streams()[stream.id];
    const std::string paths =
        scene_ ? list_paths(*scene_, poses_.names_at(stream.id, bound.unmatched_names, kNameBytesInReply))
               : "";
    if (const size_t names = bound.scene_node_of_pose.size();
        names != 0 && bound.unmatched_names.size() == names)
      report("moves nothing: the scene has no node of its " + counted(names, "name") + ", such as " +
             list_names(poses_, stream.id, bound.unmatched_names) +
             (scene_ && paths.empty() ? list_scene_nodes(*scene_) : ""));
    if (!paths.empty()) report("has names that no node has alone; write paths: " + paths);
    if (const state::IndexSet names = poses_.names_without_scale(stream.id); !names.empty())
      report("moves " + counted(names.size(), "node") +
             " without the scale of the scene file: " + list_names(poses_, stream.id, names) +
             "; multiply the scale into the poses, or apply it to the mesh");
    if (const state::IndexSet names = poses_.names_with_empty_pose(stream.id); !names.empty())
      report("has poses of zeros only for " + counted(names.size(), "node") + ": " +
             list_names(poses_, stream.id, names) +
             "; they are invisible (a pose that rotates nothing has ones on its diagonal)");
    if (!stream.advice.empty()) send_advice(peer, stream);
  }
  handled_peer_.reset();
}

void StreamReceiver::report_refusals() {
  for (const state::BudgetRefusal& refusal : poses_.take_refusals()) {
    const auto stream = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(),
                                     [&](const auto& entry) { return entry.second.id == refusal.stream; });
    if (stream == stream_of_peer_.end()) continue;
    uint32_t& reported = peers_[stream->first].reported_refusals;
    const uint32_t bit = 1u << static_cast<uint32_t>(refusal.resource);
    if ((std::exchange(reported, reported | bit) & bit) != 0) continue;
    handled_peer_ = stream->first;
    log(warning("stream \"" + stream->second.name + "\" is over a limit: " + refusal.message));
  }
  handled_peer_.reset();
}

void StreamReceiver::drop_stream(Peer peer, const std::string& reason) {
  const auto ended = stream_of_peer_.find(peer);
  log("stream \"" + ended->second.name + "\" ended: " + reason);
  images_.remove(ended->second.requester);
  stream_of_peer_.erase(ended);
}

void StreamReceiver::end_stream(Peer peer, const std::string& reason) {
  const auto ended = stream_of_peer_.find(peer);
  if (ended == stream_of_peer_.end()) return;
  poses_.remove_stream(ended->second.id);
  drop_stream(peer, reason);
}

uint64_t StreamReceiver::suspend_stream(Peer peer, const std::string& reason, bool passes_nodes) {
  const auto ended = stream_of_peer_.find(peer);
  if (ended == stream_of_peer_.end()) return 0;
  const int64_t until_ns = clock_.now_ns + kGraceNs;
  const uint64_t reservation = poses_.suspend_stream(ended->second.id, until_ns);
  std::erase_if(suspended_,
                [this](const SuspendedStream& suspended) { return suspended.until_ns <= clock_.now_ns; });
  suspended_.push_back({peer.first, ended->second.epoch, ended->second.name, reservation, until_ns});
  if (suspended_.size() > state::PoseState::kMaxReservations)
    suspended_.erase(std::max_element(
        suspended_.begin(), suspended_.end(),
        [](const SuspendedStream& a, const SuspendedStream& b) { return a.reservation < b.reservation; }));
  drop_stream(peer, reason);
  if (passes_nodes && !suspended_.empty() && suspended_.back().reservation == reservation)
    pass_nodes_to_successor(suspended_.back());
  return reservation;
}

// Reconnection: the epoch identifies the same run; for shared memory the segment does, which belongs to one
// user and one publisher. A restarted publisher matches by name only: it is the successor until the
// earlier run reconnects in time.
void StreamReceiver::begin_stream(Peer peer, const wire::StreamDescription& description) {
  const auto same = std::find_if(suspended_.begin(), suspended_.end(), [&](const SuspendedStream& each) {
    return each.listener == peer.first && each.until_ns > clock_.now_ns && each.epoch == description.epoch &&
           each.name == name_of(description);
  });
  if (same == suspended_.end())
    return accept_stream(peer, description, claim_slot_of_suspended(peer, description));
  const SuspendedStream suspended = *same;
  suspended_.erase(same);
  if (suspended.successor_epoch == 0) return accept_stream(peer, description, suspended.reservation);
  const auto successor = stream_of_peer_.find(suspended.successor);
  const bool has_it =
      successor != stream_of_peer_.end() && successor->second.epoch == suspended.successor_epoch;
  if (!has_it)
    return accept_stream(
        peer, description,
        suspended.has_nodes_only ? suspended.reservation : claim_slot_of_suspended(peer, description));
  const std::string reason = "the stream whose place it had has returned";
  refuse_description(suspended.successor, suspended.successor_epoch, wire::WelcomeStatus::refused, reason);
  if (!suspended.has_nodes_only)
    return accept_stream(peer, description, suspend_stream(suspended.successor, reason, false));
  accept_stream(peer, description, suspended.reservation);
  end_stream(suspended.successor, reason);  // its nodes go to the oldest stream that waits for them
}

uint64_t StreamReceiver::claim_slot_of_suspended(Peer peer, const wire::StreamDescription& description) {
  const bool has_one_publisher = listeners_[peer.first]->uri().starts_with("shm://");
  const auto suspended = std::find_if(suspended_.begin(), suspended_.end(), [&](const SuspendedStream& each) {
    return each.listener == peer.first && each.until_ns > clock_.now_ns && each.successor_epoch == 0 &&
           (has_one_publisher || each.name == name_of(description));
  });
  if (suspended == suspended_.end()) return 0;
  suspended->successor = peer;
  suspended->successor_epoch = description.epoch;
  return suspended->reservation;
}

// Same as claim_slot_of_suspended(), for a stream that connected before the loss was detected. A stream of
// the name that waits for no node is another publisher.
void StreamReceiver::pass_nodes_to_successor(SuspendedStream& suspended) {
  const auto next = std::find_if(stream_of_peer_.begin(), stream_of_peer_.end(), [&](const auto& entry) {
    return entry.first.first == suspended.listener && entry.second.name == suspended.name &&
           !poses_.streams()[entry.second.id].conflicting_names.empty();
  });
  if (next == stream_of_peer_.end()) return;
  suspended.successor = next->first;
  suspended.successor_epoch = next->second.epoch;
  suspended.has_nodes_only = true;
  poses_.pass_reserved_nodes(suspended.reservation, next->second.id);
}

// The older connection may be dead without notice: pings it, and takes its stream if it stays silent.
void StreamReceiver::begin_conflict(Peer peer, const wire::StreamDescription& description, Peer older) {
  PeerStream& stream = stream_of_peer_.at(older);
  const bool may_be_same = older.first == peer.first && stream.name == name_of(description);
  const int64_t decide_ns = std::max(peers_[older].last_message_ns + kSilentNs, clock_.now_ns + kAnswerNs);
  peers_.at(peer).conflict = EpochConflict{older, description.epoch, may_be_same, clock_.now_ns, decide_ns};
  scheduler_.hold(peer, true);
  send_status(older, stream,
              "another connection publishes this run of the stream; this one keeps it while it lives");
  reply(older, wire::encode(wire::Ping{UINT64_MAX, static_cast<uint64_t>(clock_.now_ns)}));
}

void StreamReceiver::resolve_conflicts() {
  for (auto& [peer, state] : peers_) {
    if (!state.conflict) continue;
    const EpochConflict conflict = *state.conflict;
    const auto older = stream_of_peer_.find(conflict.older);
    const bool ended = older == stream_of_peer_.end() || older->second.epoch != conflict.epoch;
    const int64_t last_message_ns = ended ? 0 : peers_[conflict.older].last_message_ns;
    if (!ended && last_message_ns <= conflict.pinged_ns && clock_.now_ns < conflict.decide_ns) continue;
    state.conflict.reset();
    scheduler_.hold(peer, false);
    if (ended) continue;
    if (last_message_ns > conflict.pinged_ns || !conflict.may_be_same) {
      state.refused_epoch = conflict.epoch;
      state.refused_ns = clock_.now_ns;
      handled_peer_ = peer;
      log(warning("stream \"" + older->second.name + "\": another connection (" +
                  listeners_[peer.first]->uri() + " peer " + std::to_string(peer.second) +
                  ") that publishes the same run was refused"));
    } else {
      suspend_stream(conflict.older, "it came back over another connection", false);
    }
  }
  handled_peer_.reset();
}

}  // namespace fire3dv::app
