// Listener link of a fuzzed session: delivers queued events and records the replies.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "protocol/base/error.h"
#include "protocol/transport/link.h"
#include "protocol/wire/decode.h"

namespace fire3dv::fuzz {

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

}  // namespace fire3dv::fuzz
