// In-process publisher link: queues published messages for a listener in the same process.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "protocol/transport/link.h"

namespace fire3dv::replay {

struct QueuedEvent {
  transport::LinkEvent::Kind kind{};
  transport::PeerId peer = 0;
  wire::Bytes message;
};

class QueueLink final : public transport::PublisherLink {
 public:
  // Borrows the queue, which must outlive this object.
  QueueLink(std::deque<QueuedEvent>& queue, transport::PeerId peer) : queue_(queue), peer_(peer) {}

  size_t max_pose_message_bytes() const override { return size_t{256} << 20; }  // the limit of decoders
  Result<void> set_description(std::span<const std::byte> message) override {
    put(transport::LinkEvent::Kind::control, {message, {}});
    return {};
  }
  Result<void> put_state(uint64_t, transport::SharedBytes message) override {
    put(transport::LinkEvent::Kind::control, {*message, {}});
    return {};
  }
  bool publish(const wire::MessagePieces& message, bool) noexcept override {
    put(transport::LinkEvent::Kind::pose, message);
    return true;
  }
  // Every frame is published whole, so that a listener may start at any frame.
  bool takes_partial_frames() const override { return false; }
  bool publish_partial(const wire::MessagePieces&,
                       std::span<const wire::MessagePieces> whole) noexcept override {
    for (const wire::MessagePieces& piece : whole) put(transport::LinkEvent::Kind::pose, piece);
    return true;
  }
  void send_control(std::span<const std::byte> message) noexcept override {
    put(transport::LinkEvent::Kind::control, {message, {}});
  }
  bool poll(std::vector<std::byte>&) override { return false; }
  transport::LinkStats stats() const override { return {}; }

 private:
  void put(transport::LinkEvent::Kind kind, const wire::MessagePieces& message) {
    wire::Bytes bytes;
    bytes.reserve(message.size());
    bytes.insert(bytes.end(), message.head.begin(), message.head.end());
    bytes.insert(bytes.end(), message.body.begin(), message.body.end());
    queue_.push_back({kind, peer_, std::move(bytes)});
  }

  std::deque<QueuedEvent>& queue_;
  transport::PeerId peer_;
};

}  // namespace fire3dv::replay
