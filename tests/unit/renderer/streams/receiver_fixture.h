// Stream receiver without links and a GPU: a scripted listener delivers the messages.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>

#include "protocol/wire/encode.h"
#include "renderer/streams/image_request_queue.h"
#include "renderer/streams/playout_options.h"
#include "renderer/streams/stream_receiver.h"

namespace fire3dv::app {

using transport::LinkEvent;
using transport::PeerId;

// Delivers the test's messages and records the replies.
class ScriptedListener final : public transport::ListenerLink {
 public:
  void poll(const std::function<void(const LinkEvent&)>& on_event) override {
    while (!script_.empty()) {
      const Entry entry = std::move(script_.front());
      script_.pop_front();
      on_event({entry.kind, entry.peer, entry.message, entry.text, 0});
    }
  }
  void wait(std::chrono::nanoseconds) override {}
  void pause_peer(PeerId peer, bool is_paused) override { pauses.emplace_back(peer, is_paused); }
  void send(PeerId peer, std::span<const std::byte> message) override {
    sent.emplace_back(peer, wire::Bytes(message.begin(), message.end()));
  }
  transport::LinkStats stats() const override { return {}; }
  std::string uri() const override { return address; }

  void deliver(PeerId peer, LinkEvent::Kind kind, wire::Bytes message = {}, std::string text = {}) {
    script_.push_back({kind, peer, std::move(message), std::move(text)});
  }

  std::shared_ptr<PeerBudget> budget(PeerId peer) const override {
    const auto known = budgets.find(peer);
    return known == budgets.end() ? nullptr : known->second;
  }
  bool carries_images() const override { return carries; }
  bool carries_input() const override { return takes_input; }
  bool send_image(PeerId peer, uint64_t request, std::span<const std::byte>, size_t pixel_bytes,
                  const FillPixels& fill) override {
    std::vector<std::byte> pixels(pixel_bytes);
    fill(pixels);
    images.push_back({peer, request, std::move(pixels)});
    return true;
  }

  std::vector<std::pair<PeerId, wire::Bytes>> sent;
  std::vector<std::pair<PeerId, bool>> pauses;
  struct Image {
    PeerId peer;
    uint64_t request;
    std::vector<std::byte> pixels;
  };
  std::vector<Image> images;
  std::map<PeerId, std::shared_ptr<PeerBudget>> budgets;
  bool carries = true, takes_input = true;
  std::string address = "test://listener";

 private:
  struct Entry {
    LinkEvent::Kind kind;
    PeerId peer;
    wire::Bytes message;
    std::string text;
  };
  std::deque<Entry> script_;
};

class StreamReceiverTest : public ::testing::Test {
 protected:
  StreamReceiverTest() : scene_(make_scene()), poses_(scene_), receiver_(poses_, false) {
    auto listener = std::make_unique<ScriptedListener>();
    link_ = listener.get();
    receiver_.add(std::move(listener));
    receiver_.set_clock([this] { return now_ns_ += step_ns_; });
  }

  static scene::Scene make_scene() {
    scene::Scene scene;
    scene::Node node;
    node.name = node.path = "arm";
    scene.nodes.push_back(node);
    return scene;
  }

  static wire::Bytes description(uint64_t epoch, const std::string& name = "adapter",
                                 std::vector<std::string> nodes = {"arm"}) {
    wire::StreamDescription d;
    d.epoch = epoch;
    d.adapter_name = name;
    d.node_names = std::move(nodes);
    return wire::encode(d);
  }
  static wire::Bytes visible(uint64_t epoch, uint64_t version) {
    return wire::encode(
        wire::SceneEdit{epoch, version, "arm", wire::Property::visible, wire::Visible{false}});
  }
  // Returns the epoch of the stream that drives the arm; 0: none.
  uint64_t driver() const {
    const std::optional<uint64_t> age = poses_.age_of_driver(0);
    for (const state::Stream& stream : poses_.streams()) {
      if (age && stream.active && stream.scene_node_of_pose[0] == 0) return stream.epoch;
    }
    return 0;
  }

  static wire::Bytes frame(uint64_t epoch, uint64_t sequence) {
    static const wire::Affine3x4 pose;
    wire::PoseFrameView view;
    view.header.epoch = epoch;
    view.header.sequence = sequence;
    view.node_count = 1;
    view.poses = {&pose, 1};
    return wire::encode(view);
  }

  static wire::ImageRequest image_request(uint64_t epoch, uint64_t id) {
    wire::ImageRequest request;
    request.epoch = epoch;
    request.id = id;
    request.place = static_cast<uint32_t>(id);
    request.intrinsics = {8, 4, 10, 10, 3.5f, 1.5f, 0.01f, 0, {}};
    request.when = wire::ImageWhen::every_nth;
    return request;
  }

  static size_t count_of(const std::vector<std::string>& log, const std::string& text) {
    return static_cast<size_t>(std::count_if(log.begin(), log.end(), [&](const std::string& line) {
      return line.find(text) != std::string::npos;
    }));
  }
  // Polls, and counts messages about streams without frames.
  size_t count_stalls() {
    receiver_.poll();
    return count_of(receiver_.take_log_messages(), "stalled");
  }

  // Returns the answers of one type to a peer.
  template <typename T>
  std::vector<T> answers(PeerId peer) {
    std::vector<T> found;
    wire::Decoder decoder;
    for (const auto& [to, bytes] : link_->sent) {
      auto message = decoder.decode(bytes);
      EXPECT_TRUE(message.ok());
      if (to == peer && std::holds_alternative<T>(*message)) found.push_back(std::get<T>(*message));
    }
    return found;
  }

  scene::Scene scene_;
  state::PoseState poses_;
  StreamReceiver receiver_;
  ScriptedListener* link_ = nullptr;
  int64_t now_ns_ = 100'000'000'000;
  int64_t step_ns_ = 0;  // per clock read: once per handled message
};
constexpr int64_t kSecondNs = 1'000'000'000;

}  // namespace fire3dv::app
