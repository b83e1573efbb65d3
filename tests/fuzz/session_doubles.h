// Surroundings of a fuzzed session: listener link, scene uploader without devices, clock, and the oracle of
// edits that hide nodes.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/live_scene/scene_uploader.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/marker_registry.h"
#include "renderer/state/node_index.h"
#include "renderer/state/pose_state.h"
#include "tests/fuzz/session_peer.h"

namespace fire3dv::fuzz {

// Listener link of a fuzzed session: delivers queued events and records the replies.
class SessionLink final : public transport::ListenerLink {
 public:
  explicit SessionLink(bool carries_images) : carries_images_(carries_images) {}

  void deliver(transport::PeerId peer, transport::LinkEvent::Kind kind, wire::Bytes message = {}) {
    events_.push_back({kind, peer, std::move(message)});
  }
  bool idle() const { return events_.empty(); }

  void poll(const std::function<void(const transport::LinkEvent&)>& on_event) override {
    for (; !events_.empty(); events_.pop_front()) {
      const Event& event = events_.front();
      on_event({event.kind, event.peer, event.message, event.peer == 0 ? "note" : "", 0});
    }
  }
  void wait(std::chrono::nanoseconds) override {}
  // Checks that each reply is a valid message.
  void send(transport::PeerId peer, std::span<const std::byte> message) override {
    const auto decoded = decoder_.decode(message);
    FIRE3DV_ASSERT(decoded.ok());
    ++replies_;
    if (const auto* refused = std::get_if<wire::ImageRefused>(&*decoded))
      refused_.emplace_back(peer, refused->request);
    if (const auto* welcome = std::get_if<wire::Welcome>(&*decoded))
      welcomed_[peer] = {welcome->epoch, welcome->status};
  }
  bool carries_images() const override { return carries_images_; }
  bool send_image(transport::PeerId peer, uint64_t request, std::span<const std::byte> head,
                  size_t pixel_bytes, const FillPixels& fill) override {
    FIRE3DV_ASSERT(!head.empty());
    std::vector<std::byte> pixels(pixel_bytes);
    fill(pixels);
    images_.emplace_back(peer, request);
    return true;
  }
  transport::LinkStats stats() const override { return {}; }
  std::string uri() const override { return "test://session"; }

  using PeerAndRequest = std::pair<transport::PeerId, uint64_t>;
  const std::vector<PeerAndRequest>& refused() const { return refused_; }
  const std::vector<PeerAndRequest>& images() const { return images_; }
  // Returns epoch and status of the last Welcome of each peer.
  const std::map<transport::PeerId, std::pair<uint64_t, wire::WelcomeStatus>>& welcomed() const {
    return welcomed_;
  }

 private:
  struct Event {
    transport::LinkEvent::Kind kind;
    transport::PeerId peer;
    wire::Bytes message;
  };
  const bool carries_images_;
  std::deque<Event> events_;
  wire::Decoder decoder_;
  uint64_t replies_ = 0;
  std::vector<PeerAndRequest> refused_, images_;
  std::map<transport::PeerId, std::pair<uint64_t, wire::WelcomeStatus>> welcomed_;
};

// Returns a valid binary glTF file of a few nodes, for assets and the base scene.
std::vector<std::byte> small_glb();
const scene::LoadedScene& base_scene();

// Refuses some scenes for memory, as choices say.
class SessionUploader final : public app::SceneUploader {
 public:
  // choices: borrowed; null: all scenes fit from now on.
  void set_choices(Choices* choices) { choices_ = choices; }

  Result<void> check_memory(const scene::LoadedScene& next) const override;
  Result<void> upload(const scene::LoadedScene& next) override;
  uint32_t max_textures() const override { return UINT32_MAX; }
  void set_edits(const scene::SceneEdits&) override {}
  void set_markers(const std::vector<state::ShownMarker>& markers) override;
  bool lacks_markers() const override { return false; }
  uint32_t lights_without_shadow() const override { return 0; }

 private:
  Choices* choices_ = nullptr;
};

// Clock of a session. Background builds read it at their beginning and wait there while the gate is closed:
// the caller ends the builds, so equal inputs give equal sessions.
class BuildGate {
 public:
  int64_t now_ns();
  void set_open(bool is_open);
  void advance(int64_t ns);

 private:
  const std::thread::id owner_ = std::this_thread::get_id();
  std::mutex mutex_;
  std::condition_variable opened_;
  bool is_open_ = false;
  int64_t now_ns_ = 1'000'000'000;
};

// Edits in force that hide or remove nodes.
class HidingEdits {
 public:
  void add(const state::SceneChanges& change);
  // Returns the smallest age of a stream with an edit that hides or removes this node; nothing if there is
  // none.
  std::optional<uint64_t> oldest_hider(uint32_t node, const scene::Scene& scene,
                                       const state::NodeNames& names) const;

 private:
  std::map<uint64_t, std::map<std::pair<std::string, wire::Property>, bool>> hiding_;  // by age
};

}  // namespace fire3dv::fuzz
