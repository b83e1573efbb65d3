// Frame statistics of one stream: complete, split, duplicated and incomplete pose frames. Parts may arrive in
// any order.
#pragma once

#include <cstdint>

#include "base/open_frames.h"
#include "protocol/stream/frame_assembler.h"
#include "protocol/wire/messages.h"

namespace fire3dv::record {

struct FrameCounts {
  uint64_t frames = 0;   // frames with at least one received message
  uint64_t parts = 0;    // messages that carried a part of a frame
  uint64_t missing = 0;  // sequence numbers of which no message was received in time
  uint64_t late = 0;     // messages without new poses: stale, duplicated or contradictory
};

class FrameCounter {
 public:
  // Starts a new run of the stream: sequence numbers restart, counts continue.
  void begin();
  // Returns true for the first message of its frame.
  bool take(const wire::PoseFrameView& frame);

  const FrameCounts& counts() const { return counts_; }
  uint64_t newest() const { return newest_; }  // sequence; 0: none in this run
  // Number of frames with missing parts. Includes the newest frame only if the run is over, since its parts
  // may still arrive.
  uint64_t incomplete(bool is_over) const;

 private:
  struct OpenFrame {
    uint64_t sequence = 0;
    wire::PoseFrameHeader header;
    uint32_t node_count = 0;
    ElementSet arrived;  // node indices

    void clear() {
      arrived.clear();
      sequence = 0;
    }
  };
  bool add_part(OpenFrame& frame, const wire::PoseFrameView& part);

  FrameCounts counts_;
  bool open(const wire::PoseFrameView& frame);

  uint64_t first_ = 0, newest_ = 0;
  uint64_t seen_ = 0;  // bit i: a message of frame newest_ - i was received
  uint64_t given_up_ = 0;
  OpenFrames<OpenFrame, stream::kMaxOpenFrames> open_;
};

}  // namespace fire3dv::record
