// Gathers the parts of pose frames until a frame is whole. Several frames may be open at once, since a
// datagram link delivers the last part of one frame after the first part of the next; a whole frame closes
// all older ones.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/wire/messages.h"

namespace fire3dv::state {

class FrameAssembly {
 public:
  enum class Outcome {
    whole,    // frame() is complete now
    open,     // parts are still missing
    stale,    // older than every open frame, or a part that was there already
    refused,  // contradicts the parts already here, or has no place in the frame
  };

  // `part` has already been compared with the shown frame: its sequence is newer and its node_count is the
  // stream's.
  Outcome add(const wire::PoseFrameView& part);

  // The whole frame that add() spoke of; valid until the next call.
  const wire::PoseFrameHeader& header() const { return whole_->header; }
  const std::vector<wire::Affine3x4>& poses() const { return whole_->poses; }

  // Forgets the frames up to this sequence; returns how many of them were older and never became whole.
  uint64_t close_up_to(uint64_t sequence);

  // The frame of this sequence was whole, and is kept elsewhere.
  void forget(uint64_t sequence);

  // Frames given up to make room for newer ones since the last call.
  uint64_t take_given_up();

 private:
  struct OpenFrame {
    wire::PoseFrameHeader header;  // sequence 0 = free
    std::vector<wire::Affine3x4> poses;
    std::vector<bool> have;
    uint32_t missing = 0;
  };
  OpenFrame* frame_for(const wire::PoseFrameView& part);

  std::array<OpenFrame, 4> frames_;
  const OpenFrame* whole_ = nullptr;
  uint64_t given_up_ = 0;
};

}  // namespace fire3dv::state
