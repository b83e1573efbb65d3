// Listener link and edited scene of a fuzzed session: app::LiveScene without renderer and camera. The caller
// ends the builds, so equal inputs give equal sessions.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"
#include "renderer/live_scene/scene_build.h"
#include "renderer/scene/model/scene_edits.h"
#include "renderer/state/edits/edit_registry.h"
#include "renderer/state/pose_state.h"

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

class SessionScene {
 public:
  explicit SessionScene(state::PoseState& poses);

  // Applies the pending edits of streams, as app::LiveScene::follow() does between two frames.
  bool follow(bool finish_build);

  bool is_settled() const { return build_.idle() && registry_.empty(); }
  const scene::Scene& scene() const { return merged_ ? merged_->scene : base_scene().scene; }
  // Returns the nodes hidden or removed by an edit, except for those that their own stream has withdrawn.
  const std::set<uint32_t>& hidden() const { return hidden_; }
  // Returns the smallest age of a stream with an edit that hides or removes this node; nothing if there is
  // none.
  std::optional<uint64_t> oldest_hider(uint32_t node) const;

 private:
  using Keys = std::vector<std::pair<uint64_t, uint64_t>>;
  void note_hiding(const std::vector<state::SceneChanges>& changes);
  bool show_built(app::SceneBuild::Built&& built);
  void begin_build(std::vector<state::RequestedNode> wanted, const std::vector<std::string>& vertex_nodes);
  void resolve(const std::vector<state::RequestedNode>& wanted);

  state::PoseState& poses_;
  state::EditRegistry registry_;
  scene::SceneEdits edits_;
  std::unique_ptr<const scene::LoadedScene> merged_;
  std::vector<state::RequestedNode> added_;
  Keys nodes_;
  std::vector<std::string> vertex_nodes_;
  std::map<uint64_t, std::map<std::pair<std::string, wire::Property>, bool>> hiding_;  // by age
  std::set<uint32_t> hidden_;
  app::SceneBuild build_;
};

}  // namespace fire3dv::fuzz
