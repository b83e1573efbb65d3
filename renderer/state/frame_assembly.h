// Assembly of pose frames from their parts. Several frames may be open at once, since a datagram link
// delivers the last part of one frame after the first part of the next; a whole frame closes all older ones.
// Memory is allocated and charged for the poses that have arrived, not for the node count that a part claims.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "protocol/wire/messages.h"
#include "renderer/state/pose_memory.h"

namespace fire3dv::state {

class FrameAssembly {
 public:
  enum class Outcome {
    whole,        // frame() is complete now
    open,         // parts are still missing
    stale,        // older than every open frame, or a part that was there already
    refused,      // contradicts the parts already here, or has no place in the frame
    over_budget,  // the peer's budget has no room for its poses
  };

  FrameAssembly() = default;
  // Null: without limits.
  explicit FrameAssembly(std::shared_ptr<PeerBudget> budget) : memory_(std::move(budget)) {}

  // `part` has already been compared with the shown frame: its sequence is newer and its node_count is the
  // stream's.
  Outcome add(const wire::PoseFrameView& part);

  // The whole frame of the last add(); valid until the next call.
  const wire::PoseFrameHeader& header() const { return whole_header_; }
  const std::vector<wire::Affine3x4>& poses() const { return whole_poses_; }

  // Closes the frames up to this sequence; returns how many of them were older and never became whole.
  uint64_t close_up_to(uint64_t sequence);

  // Closes the frame of this sequence, which was whole and is stored elsewhere.
  void forget(uint64_t sequence);

  // Frames given up to make room for newer ones since the last call.
  uint64_t take_given_up();

  // Bytes of poses that this holds.
  size_t memory_bytes() const { return memory_.amount(); }

 private:
  static constexpr size_t kChunkPoses = 256;
  struct Chunk {
    std::array<wire::Affine3x4, kChunkPoses> poses;
    std::bitset<kChunkPoses> have;
  };
  struct OpenFrame {
    wire::PoseFrameHeader header;  // sequence 0 = free
    uint32_t node_count = 0;
    uint32_t missing = 0;
    std::vector<std::unique_ptr<Chunk>> chunks;  // null where no pose has arrived
  };
  OpenFrame* frame_for(const wire::PoseFrameView& part);
  bool make_chunks(OpenFrame& frame, size_t begin, size_t end);
  bool make_whole(OpenFrame& frame);
  void close(OpenFrame& frame);

  std::array<OpenFrame, 4> frames_;
  std::vector<std::unique_ptr<Chunk>> spare_;  // of frames that were closed
  wire::PoseFrameHeader whole_header_;
  std::vector<wire::Affine3x4> whole_poses_;
  PoseMemory memory_;
  uint64_t given_up_ = 0;
};

}  // namespace fire3dv::state
