// Encoder: messages to bytes. No I/O.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/wire/messages.h"

namespace fire3dv::wire {

using Bytes = std::vector<std::byte>;

Bytes encode(const StreamDescription& description);
Bytes encode(const Welcome& welcome);
Bytes encode(const Status& status);
Bytes encode(const Ack& ack);
Bytes encode(const Ping& ping);
Bytes encode(const Pong& pong);
Bytes encode(const Goodbye& goodbye);
Bytes encode(const SceneEdit& edit);
Bytes encode(const ImageRequest& request);
Bytes encode(const ImageFrame& frame);
Bytes encode(const ImageRefused& refused);
Bytes encode(const InputEvent& event);
// Patches the epoch of an encoded SceneEdit: a restarted stream retains its edits, which may be large.
void set_epoch(Bytes& scene_edit, uint64_t epoch);
// For tests, recordings and partial frames; publishers use PoseFrameEncoder.
Bytes encode(const PoseFrameView& frame);

// Message in two consecutive pieces. The second is the caller's pose array, so that poses are copied once,
// from the simulator into the link.
struct MessagePieces {
  std::span<const std::byte> head;
  std::span<const std::byte> body;
  size_t size() const { return head.size() + body.size(); }
};

// Pose frame encoder of one stream. Builds the head once and patches its fields per frame: encode() neither
// allocates (after the first call) nor copies poses. Not thread-safe; the pieces are valid until the next
// call.
class PoseFrameEncoder {
 public:
  // Encodes a whole frame or a range of nodes.
  MessagePieces encode(const PoseFrameView& frame);

 private:
  Bytes head_;
  struct Offsets {
    size_t epoch, sequence, sim_time, publish_time, scene_version, flags, node_count, first_node;
  } offsets_{};
};

// Maximum number of poses in a message of max_message_bytes, for datagram links, which split longer frames.
// Each part is an independent PoseFrameView. 0: not even one pose fits.
uint32_t poses_per_part(size_t max_message_bytes);

}  // namespace fire3dv::wire
