// Counts the frames of a stream as they come: whole, or in parts that may be in any order and that may be
// missing.
#pragma once

#include <array>
#include <cstdint>

#include "protocol/wire/messages.h"

namespace fire3dv::record {

struct FrameCounts {
  uint64_t frames = 0;   // of which anything came
  uint64_t parts = 0;    // messages that were a part of a frame
  uint64_t missing = 0;  // sequences of which nothing came before a newer one did
  uint64_t late = 0;     // messages of frames that were over: they came after newer ones, or twice
};

class FrameTally {
 public:
  // A new run of the stream: sequences begin anew. Counts go on.
  void begin();
  // True: the first that came of its frame.
  bool take(const wire::PoseFrameView& frame);

  const FrameCounts& counts() const { return counts_; }
  uint64_t newest() const { return newest_; }  // sequence; 0: none of this run
  // Frames of which parts are missing. The newest may still be coming, unless all of it is over.
  uint64_t incomplete(bool is_over) const;

 private:
  struct Open {
    uint64_t sequence = 0;  // 0: free
    uint32_t covered = 0;   // nodes
  };

  FrameCounts counts_;
  uint64_t newest_ = 0;
  uint64_t given_up_ = 0;
  // As many as a renderer has open: datagrams of one frame come after the first of the next.
  std::array<Open, 4> open_;
};

}  // namespace fire3dv::record
