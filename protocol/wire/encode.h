// Messages to bytes. Nothing here does I/O.
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
// Changes the epoch of an encoded SceneEdit: a stream that begins anew keeps its edits, which may be large.
void set_epoch(Bytes& scene_edit, uint64_t epoch);
// For tests, recordings and partial frames; else a publisher uses PoseFrameEncoder.
Bytes encode(const PoseFrameView& frame);

// A message in two pieces that stand one after the other on the wire. The second is the caller's own pose
// array, so that a pose is copied once: from the simulator into the link.
struct MessagePieces {
  std::span<const std::byte> head;
  std::span<const std::byte> body;
  size_t size() const { return head.size() + body.size(); }
};

// Encodes the pose frames of one stream. The head is laid out once; each frame only patches the header fields
// in place, so that encode() neither allocates (after the first call) nor copies poses. Not thread-safe; the
// pieces are valid until the next call.
class PoseFrameEncoder {
 public:
  // Of a whole frame, or of consecutive nodes.
  MessagePieces encode(const PoseFrameView& frame);

 private:
  Bytes head_;
  struct Offsets {
    size_t epoch, sequence, sim_time, publish_time, scene_version, flags, node_count, first_node;
  } offsets_{};
};

// How many poses a message of at most max_message_bytes holds, for datagram links: a longer frame is cut into
// parts of so many poses. Each part is a PoseFrameView of its own and useful alone. 0: not even one pose
// fits.
uint32_t poses_per_part(size_t max_message_bytes);

}  // namespace fire3dv::wire
