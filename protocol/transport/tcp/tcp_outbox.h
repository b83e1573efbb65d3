// Send queue of a TCP publisher: ordered control messages, keyed states and the newest pose. Sending never
// blocks, so that the simulator's thread may send while it holds the lock.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "protocol/transport/core/keyed_states.h"
#include "protocol/transport/core/network_link.h"
#include "protocol/transport/tcp/tcp_frame.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::tcp {

enum class SendOutcome { done, would_block, broken };

// Encryption of outgoing bytes. Sealed bytes must be sent: the receiver counts the records.
class Sealer {
 public:
  virtual ~Sealer() = default;
  // Appends the sealed bytes to `to`. Returns false if the connection cannot continue.
  virtual bool seal(std::span<const std::byte> plain, std::vector<std::byte>& to) = 0;
};

class Outbox {
 public:
  // Resets the connection state. Retains keyed states and the newest pose: the next peer receives it even if
  // the simulator pauses or waits in lockstep. sealer null: no encryption.
  void start_connection(Sealer* sealer);

  // Sends the pose if the queue is empty; otherwise queues it. *overtook is set if it replaced a queued pose.
  // fd -1: not connected.
  SendOutcome pose(int fd, const wire::MessagePieces& message, bool& overtook);

  // Queues a control message after the others and before the pose. Returns false if more than `limit` bytes
  // are queued already.
  bool control(SharedBytes message, size_t limit);

  // Sends `partial` if the queue is empty and the connection has received a whole frame; otherwise queues
  // `whole`.
  SendOutcome partial_pose(int fd, const wire::MessagePieces& partial, const wire::MessagePieces& whole,
                           bool& overtook);

  // Queues a state after the partially sent message; a later state of its key may replace it.
  void state(uint64_t key, SharedBytes message) { states_.put(key, std::move(message)); }
  // Drops the states of the earlier description, and requires a whole frame next.
  void start_description();

  // Queues bytes of the sealer itself (handshake, alerts) before everything else.
  void sealed(std::span<const std::byte> bytes);

  // Drops the newest pose; returns true if it was queued and never sent.
  bool drop_pose();

  bool waits_to_send() const {
    return at_ < bytes_.size() || !controls_.empty() || has_pose_ || batches_.has_unsent(states_);
  }
  // Sends until the socket is full, at most about 256 KiB, to release the lock soon.
  SendOutcome flush(int fd);

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  struct Control {
    SharedBytes message;
    FrameKind kind = FrameKind::control;
    size_t at = 0;  // bytes of header and message already queued
  };
  SendOutcome send_pose(int fd, FrameKind kind, const wire::MessagePieces& message,
                        const wire::MessagePieces& whole, bool& overtook);
  void mark_pose_sent();
  void store_pose(const FrameHeader& header, const wire::MessagePieces& message);
  bool refill();
  bool take_from_control();

  Sealer* sealer_ = nullptr;
  std::vector<std::byte> bytes_;  // from at_ on: sent before everything else
  size_t at_ = 0;
  std::deque<Control> controls_;
  size_t control_bytes_ = 0;
  KeyedStates states_;
  StateBatches batches_;
  bool snapshot_begun_ = false;    // the initial states of a joiner, which precede its first pose
  bool has_base_ = false;          // a whole frame was sent, so that partial frames are valid
  std::vector<std::byte> pose_;    // newest whole pose, framed; retained after sending
  std::vector<std::byte> framed_;  // reused buffer for sealing
  bool has_pose_ = false;          // pose_ is queued
  bool pose_was_sent_ = false;     // pose_ was sent on this or an earlier connection
  uint64_t bytes_sent_ = 0;
};

}  // namespace fire3dv::transport::tcp
