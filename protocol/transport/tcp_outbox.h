// What a TCP publisher has yet to send: ordered bytes that must go out, then the newest pose. Sending never
// waits, so that it may be done from the simulator's thread while the lock is held.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "protocol/transport/tcp_frame.h"
#include "protocol/wire/encode.h"

namespace fire3dv::transport::tcp {

enum class SendOutcome { done, would_block, broken };

class Outbox {
 public:
  // Forgets what belonged to an earlier connection, but keeps the newest pose.
  void start_connection();

  // Sends at once when nothing waits before it; else it becomes the waiting pose. True in *overtook when
  // another pose was given up for it. fd -1: not connected.
  SendOutcome pose(int fd, const wire::MessagePieces& message, bool& overtook);

  // Behind all other control messages and before the waiting pose. False when too much waits already.
  bool control(std::span<const std::byte> message, size_t limit);

  // Gives up the waiting pose; true when there was one.
  bool drop_pose();

  bool waits_to_send() const { return at_ < bytes_.size() || has_pose_; }
  // Sends what the socket takes, but at most about 256 KiB, so that the lock is soon free again.
  SendOutcome flush(int fd);

  uint64_t bytes_sent() const { return bytes_sent_; }

 private:
  void keep_pose(const FrameHeader& header, const wire::MessagePieces& message);

  std::vector<std::byte> bytes_;  // from at_ on: to be sent before anything else
  size_t at_ = 0;
  std::vector<std::byte> pose_;  // the newest, framed
  bool has_pose_ = false;
  uint64_t bytes_sent_ = 0;
};

}  // namespace fire3dv::transport::tcp
