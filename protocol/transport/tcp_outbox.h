// What a TCP publisher has yet to send: ordered messages that must go out, keyed states, the newest pose.
// Sending never waits, so that it may be done from the simulator's thread while the lock is held.
#pragma once

#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "protocol/transport/keyed_states.h"
#include "protocol/transport/network_publisher.h"
#include "protocol/transport/tcp_frame.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::tcp {

enum class SendOutcome { done, would_block, broken };

// Encrypts what goes out. Bytes that were sealed have to be sent: the receiver counts the records.
class Sealer {
 public:
  virtual ~Sealer() = default;
  // Appends the sealed bytes to `to`. False: this connection cannot go on.
  virtual bool seal(std::span<const std::byte> plain, std::vector<std::byte>& to) = 0;
};

class Outbox {
 public:
  // Forgets what belonged to an earlier connection, but for the newest pose: whoever is reached next gets it
  // too, or a simulator that pauses, or waits in lockstep, would not be seen. Keyed states stay. sealer null:
  // plain bytes.
  void start_connection(Sealer* sealer);

  // Sends at once when nothing waits before it; else it becomes the waiting pose. True in *overtook when
  // another pose was given up for it. fd -1: not connected.
  SendOutcome pose(int fd, const wire::MessagePieces& message, bool& overtook);

  // Behind all other control messages and before the waiting pose. False when more than `limit` bytes wait
  // already.
  bool control(SharedBytes message, size_t limit);

  // Sends at once what says `partial` when nothing waits before it and the connection has had a whole frame;
  // else the whole one becomes the waiting pose.
  SendOutcome partial_pose(int fd, const wire::MessagePieces& partial, const wire::MessagePieces& whole,
                           bool& overtook);

  // Goes out after what the socket has begun to take; a later message of the key may take its place.
  void state(uint64_t key, SharedBytes message) { states_.put(key, std::move(message)); }
  // What belongs to the earlier description is over: its states, and that the peer has a whole frame.
  void start_description();

  // Bytes of the sealer's own (handshake, alerts), before anything else.
  void sealed(std::span<const std::byte> bytes);

  // Gives up the newest pose; true when it waited and nobody has had it.
  bool drop_pose();

  bool waits_to_send() const {
    return at_ < bytes_.size() || !controls_.empty() || has_pose_ || batches_.has_news(states_);
  }
  // Sends what the socket takes, but at most about 256 KiB, so that the lock is soon free again.
  SendOutcome flush(int fd);

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  struct Control {
    SharedBytes message;
    FrameKind kind = FrameKind::control;
    size_t at = 0;  // bytes of header and message that were taken from it
  };
  SendOutcome send_pose(int fd, FrameKind kind, const wire::MessagePieces& message,
                        const wire::MessagePieces& kept, bool& overtook);
  void pose_left();
  void keep_pose(const FrameHeader& header, const wire::MessagePieces& message);
  bool refill();
  bool take_from_control();

  Sealer* sealer_ = nullptr;
  std::vector<std::byte> bytes_;  // from at_ on: to be sent before anything else
  size_t at_ = 0;
  std::deque<Control> controls_;
  size_t control_bytes_ = 0;
  KeyedStates states_;
  StateBatches batches_;
  bool snapshot_begun_ = false;    // the states that a joiner gets before its first pose
  bool has_base_ = false;          // a whole frame went out, on which partial ones can stand
  std::vector<std::byte> pose_;    // the newest, whole and framed; kept when it was sent
  std::vector<std::byte> framed_;  // what is sealed at once
  bool has_pose_ = false;          // it waits to be sent
  bool pose_left_ = false;         // it was sent, to this connection or to one before
  uint64_t bytes_sent_ = 0;
};

}  // namespace fire3dv::transport::tcp
