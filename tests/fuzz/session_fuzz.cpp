// Fuzz target of whole sessions of several peers in one process, from links to the edited scene, without a
// GPU. Peers connect, describe, publish, edit, request images, leave and return in any order. Invariants
// after each step: consistent state, rights of older streams, budgets of all peers. After the last disconnect
// all memory is released.
#include <malloc.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <map>
#include <thread>

#include "renderer/live_scene/live_scene.h"
#include "renderer/streams/image_request_queue.h"
#include "renderer/streams/stream_receiver.h"
#include "tests/fuzz/session_doubles.h"
#include "tests/fuzz/session_peer.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

using transport::LinkEvent;

constexpr size_t kPeers = 6;
constexpr int kSteps = 160;
constexpr size_t kMaxHeapGrowthBytes = size_t{96} << 20;

// Small limits, so that sessions reach them.
PeerLimits small_limits() {
  PeerLimits limits;
  limits.of(Resource::names) = 1000;
  limits.of(Resource::edits) = 12;
  limits.of(Resource::edit_bytes) = 100 << 10;
  limits.of(Resource::nodes) = 16;
  limits.of(Resource::lights) = 3;
  limits.of(Resource::requests) = 6;
  limits.of(Resource::pose_bytes) = 256 << 10;
  return limits;
}

state::ImageAbilities abilities() {
  state::ImageAbilities abilities;
  abilities.outputs = wire::kColorSrgb8 | wire::kDepthF32;
  return abilities;
}

class Session {
 public:
  explicit Session(std::span<const uint8_t> input)
      : choices_(input),
        lockstep_(choices_.one_in(4)),
        poses_(base_scene().scene),
        scene_(base_scene(), poses_, uploader_, assets()),
        receiver_(poses_, lockstep_, play(), budgets_),
        requests_(receiver_.images(), abilities()) {
    auto link = std::make_unique<SessionLink>(!choices_.one_in(8));
    link_ = link.get();
    receiver_.add(std::move(link));
    receiver_.set_clock([this] { return clock_.now_ns(); });
    uploader_.set_choices(&choices_);
    scene_.observe_edits([this](const state::SceneChanges& change) { hiding_.add(change); });
    scene_.charge_edit_time(
        [this](state::StreamId stream, int64_t ns) { receiver_.add_edit_time(stream, ns); });
    receiver_.images().set_handler(&requests_);
  }

  void run() {
    for (int i = 0; i < kSteps; ++i) {
      const uint64_t messages = 1 + choices_.below(8);
      for (uint64_t m = 0; m < messages; ++m) act(choices_.below(kPeers));
      turn();
    }
    for (int i = 0; i < 20; ++i) turn(true);
    check_requests();
    uploader_.set_choices(nullptr);
    for (size_t i = 0; i < kPeers; ++i)
      if (peers_[i].is_connected) disconnect(i);
    for (int i = 0; i < 1000 && (i < 20 || !is_over()); ++i) {
      clock_.advance(1'000'000'000);  // beyond all grace times
      turn(true);
    }
    check_released();
  }

 private:
  struct Owned {
    state::StreamId stream;
    uint64_t epoch, age;
  };

  app::PlayOptions play() {
    app::PlayOptions play;
    if (choices_.one_in(3)) play.mode = app::PlayOptions::Mode::interpolate;
    return play;
  }

  app::AssetSettings assets() {
    app::AssetSettings settings;
    settings.now_ns = [this] { return clock_.now_ns(); };
    return settings;
  }

  // finish_build: a running build ends and is shown.
  bool follow(bool finish_build) {
    if (finish_build && scene_.is_building()) {
      clock_.set_open(true);
      while (!scene_.has_finished_build()) std::this_thread::sleep_for(std::chrono::microseconds(20));
      clock_.set_open(false);
    }
    const bool shown = scene_.follow();
    scene_.show_markers();
    (void)scene_.take_log_messages();
    return shown;
  }

  void act(size_t index) {
    SessionPeer& peer = peers_[index];
    if (!peer.is_connected) {
      peer.reset();
      peer.is_connected = true;
      ids_[index] = ++last_id_;
      link_->deliver(ids_[index], LinkEvent::Kind::connected);
      return;
    }
    const auto say = [&](wire::Bytes message, LinkEvent::Kind kind = LinkEvent::Kind::control) {
      if (choices_.one_in(300) && !message.empty()) {
        message[choices_.below(message.size())] ^= static_cast<std::byte>(1 << choices_.below(8));
        peer.is_damaged = true;
      }
      link_->deliver(ids_[index], kind, std::move(message));
    };
    switch (choices_.below(16)) {
      case 0:
      case 1:
        return describe(index, say);
      case 2:
      case 3:
      case 4:
      case 5:
        return say(peer.pose_frame(choices_), LinkEvent::Kind::pose);
      case 6:
      case 7:
      case 8:
      case 9:
      case 10:
        return say(peer.edit(choices_));
      case 11:
      case 12:
        return say(peer.image_request(choices_));
      case 13:
        return say(SessionPeer::other_message(choices_));
      case 14:
        if (choices_.one_in(4)) return say(peer.goodbye(choices_));
        return;
      default:
        if (choices_.one_in(4)) disconnect(index);
    }
  }

  template <typename Say>
  void describe(size_t index, Say&& say) {
    const std::set<uint64_t> others = epochs_without(index);
    wire::Bytes message = peers_[index].describe(choices_, others);
    if (others.contains(peers_[index].epoch)) contested_.insert(peers_[index].epoch);
    say(std::move(message));
  }

  void disconnect(size_t index) {
    link_->deliver(ids_[index], LinkEvent::Kind::disconnected);
    peers_[index].reset();
  }

  std::set<uint64_t> epochs_without(size_t index) const {
    std::set<uint64_t> epochs;
    for (size_t i = 0; i < kPeers; ++i)
      if (i != index && peers_[i].epoch != 0) epochs.insert(peers_[i].epoch);
    return epochs;
  }

  // Leaves some images for later turns, as an expired time slice does.
  void draw(const state::ImageRequestRegistry::Due& due) {
    if (choices_.one_in(8)) return;
    if (choices_.one_in(8)) {
      requests_.refuse(due, wire::ImageRefusal::unknown_camera, "no such camera");
      return;
    }
    wire::ImageFrame frame;
    frame.request = due.request.id;
    frame.number = due.number;
    frame.epoch = due.request.epoch;
    frame.sequence = due.sequence;
    frame.intrinsics = due.request.intrinsics;
    frame.intrinsics.fx = frame.intrinsics.fy = 1;
    requests_.mark_rendered(due);
    (void)requests_.send(due.requester, frame, [](std::span<std::byte>) {});
  }

  // One iteration of the frame loop.
  void turn(bool finish = false) {
    clock_.advance(choices_.one_of<int64_t>({0, 1'000, 1'000'000, 1'000'000, 100'000'000, 6'000'000'000}));
    const int64_t now_ns = clock_.now_ns();
    receiver_.poll();
    const bool replaced = follow(finish || choices_.one_in(2));
    if (replaced || choices_.one_in(4)) receiver_.notify_bindings();
    for (const state::ImageDemand& demand : requests_.demands(now_ns)) {
      for (const state::ImageRequestRegistry::Due& due : requests_.due(demand.requester, now_ns)) draw(due);
    }
    if (choices_.one_in(2)) receiver_.acknowledge(poses_.shown());
    (void)receiver_.take_log_messages();
    (void)receiver_.report();
    check_scene();
    check_bindings();
    check_rights();
    check_budgets();
    FIRE3DV_ASSERT(::mallinfo2().uordblks <= heap_bytes_ + kMaxHeapGrowthBytes);
  }

  void check_scene() const {
    const scene::Scene& scene = scene_.scene();
    for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
      const uint32_t parent = scene.nodes[node].parent;
      FIRE3DV_ASSERT(parent == scene::kNone || parent < node);
    }
  }

  void check_bindings() const {
    const auto& drives = poses_.node_drives();
    const auto& streams = poses_.streams();
    FIRE3DV_ASSERT(drives.size() == scene_.scene().nodes.size());
    for (const state::NodeDrive& drive : drives) {
      if (drive.stream == state::kNone) continue;
      FIRE3DV_ASSERT(drive.stream < streams.size() && streams[drive.stream].active);
      FIRE3DV_ASSERT(drive.pose_index < streams[drive.stream].scene_node_of_pose.size());
    }
    std::set<uint32_t> driven;
    size_t active = 0;
    for (const state::Stream& stream : streams) {
      active += stream.active;
      if (!stream.active) continue;
      for (const uint32_t node : stream.scene_node_of_pose) {
        if (node == state::kNone) continue;
        FIRE3DV_ASSERT(node < drives.size() && driven.insert(node).second);
        FIRE3DV_ASSERT(poses_.age_of_driver(node).has_value());
      }
    }
    FIRE3DV_ASSERT(active == receiver_.active_streams());
  }

  // True if the stream has not been described again, possibly by another connection. Known only while it
  // drives a node: each run has its own age.
  bool is_same_run(const Owned& owned) const {
    const state::Stream& stream = poses_.streams()[owned.stream];
    if (!stream.active || stream.epoch != owned.epoch) return false;
    for (const uint32_t node : stream.scene_node_of_pose)
      if (node != state::kNone) return poses_.age_of_driver(node) == owned.age;
    return false;
  }

  // By an edit, not since its own stream has withdrawn it.
  bool is_hidden(uint32_t node) const {
    const auto edit = scene_.edits().nodes().find(node);
    if (edit == scene_.edits().nodes().end() || scene_.withdrawn_nodes().contains(node)) return false;
    return edit->second.hidden || edit->second.removed;
  }

  // Nodes that an older stream drives keep their driver, their paths and their visibility.
  void check_rights() {
    const std::vector<scene::Node>& nodes = scene_.scene().nodes;
    std::multimap<std::string, uint32_t> by_path;
    for (uint32_t node = 0; node < nodes.size(); ++node) by_path.emplace(nodes[node].path, node);
    const auto& streams = poses_.streams();
    for (const auto& [path, owned] : owned_) {
      if (!is_same_run(owned) || by_path.count(path) == 0) continue;
      FIRE3DV_ASSERT(by_path.count(path) == 1);
      const std::optional<uint64_t> age = poses_.age_of_driver(by_path.find(path)->second);
      FIRE3DV_ASSERT(age && state::age_rank(*age) <= state::age_rank(owned.age));
    }
    owned_.clear();
    for (state::StreamId id = 0; id < streams.size(); ++id) {
      if (!streams[id].active) continue;
      for (const uint32_t node : streams[id].scene_node_of_pose) {
        if (node == state::kNone) continue;
        const uint64_t age = *poses_.age_of_driver(node);
        owned_[nodes[node].path] = {id, streams[id].epoch, age};
        for (uint32_t at = node; at != scene::kNone; at = nodes[at].parent) {
          if (!is_hidden(at)) continue;
          const std::optional<uint64_t> hider = hiding_.oldest_hider(at, scene_.scene(), poses_.names());
          FIRE3DV_ASSERT(hider && state::age_rank(*hider) <= state::age_rank(age));
        }
      }
    }
  }

  void check_budgets() const {
    for (const BudgetPool::Report& report : budgets_->report())
      for (size_t i = 0; i < kResourceCount; ++i)
        FIRE3DV_ASSERT(report.used[i] <= budgets_->limits().per_peer[i]);
  }

  // Each request of an accepted stream is answered or open.
  void check_requests() const {
    if (lockstep_ || receiver_.deferred_messages() != 0) return;
    std::set<uint64_t> settled;
    for (const auto& [requester, id] : requests_.open()) settled.insert(id);
    for (const auto& [peer, id] : link_->refused()) settled.insert(id);
    for (const auto& [peer, id] : link_->images()) settled.insert(id);
    for (size_t i = 0; i < kPeers; ++i) {
      const auto welcome = link_->welcomed().find(ids_[i]);
      if (contested_.contains(peers_[i].epoch)) continue;  // the stream may belong to another connection
      if (!peers_[i].is_connected || peers_[i].is_damaged || welcome == link_->welcomed().end()) continue;
      if (welcome->second != std::pair(peers_[i].epoch, wire::WelcomeStatus::accepted)) continue;
      for (const auto& [place, id] : peers_[i].requests) FIRE3DV_ASSERT(settled.contains(id));
    }
  }

  bool is_over() const {
    return link_->idle() && receiver_.deferred_messages() == 0 && receiver_.active_streams() == 0 &&
           scene_.settled();
  }

  // After all peers have left.
  void check_released() {
    FIRE3DV_ASSERT(is_over());
    FIRE3DV_ASSERT(requests_.count() == 0);
    FIRE3DV_ASSERT(scene_.scene().nodes.size() == base_scene().scene.nodes.size());
    for (size_t i = 0; i < kResourceCount; ++i) FIRE3DV_ASSERT(budgets_->used(static_cast<Resource>(i)) == 0);
  }

  Choices choices_;
  const bool lockstep_;
  const std::shared_ptr<BudgetPool> budgets_ = BudgetPool::create(small_limits());
  state::PoseState poses_;
  BuildGate clock_;
  SessionUploader uploader_;
  HidingEdits hiding_;
  app::LiveScene scene_;
  app::StreamReceiver receiver_;
  app::ImageRequestQueue requests_;
  SessionLink* link_ = nullptr;
  std::array<SessionPeer, kPeers> peers_;
  std::array<transport::PeerId, kPeers> ids_{};
  transport::PeerId last_id_ = 0;
  std::set<uint64_t> contested_;  // epochs whose streams two connected peers have described
  const size_t heap_bytes_ = ::mallinfo2().uordblks;  // sanitizers report 0
  std::map<std::string, Owned> owned_;                // by path, as of the last turn
};

}  // namespace

std::vector<Input> seeds() {
  std::mt19937_64 generator(1);
  std::vector<Input> seeds(16);
  for (Input& seed : seeds)
    for (int i = 0; i < 600; ++i) seed.push_back(static_cast<uint8_t>(generator()));
  return seeds;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv::fuzz;
  Session({data, size}).run();
  return 0;
}
