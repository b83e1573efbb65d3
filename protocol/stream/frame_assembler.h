// Assembly of pose frames from their parts (SPEC.md, section 4), and the charge for their memory. Several
// frames may be open at once, since datagrams of consecutive frames arrive interleaved: as many as the jitter
// of the network spans, bounded by number and bytes. A frame is whole when every node has a pose under one
// header; it never mixes two simulation steps. Memory is allocated and charged for received poses, not for
// the claimed node count. Not thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/open_frames.h"
#include "base/peer_budget.h"
#include "protocol/wire/affine.h"
#include "protocol/wire/messages.h"

namespace fire3dv::stream {

// Budget charge for pose vectors of one peer. The charge lasts as long as this object, which is a member next
// to the vectors.
class PoseMemory {
 public:
  PoseMemory() = default;
  explicit PoseMemory(std::shared_ptr<PeerBudget> budget) {
    charge_ = std::move(*BudgetCharge::take(std::move(budget), Resource::pose_bytes, 0));
  }

  // Charges memory before its allocation. Returns false if it exceeds the budget.
  bool take(size_t pose_count) { return charge_.resize(charge_.amount() + bytes(pose_count)).ok(); }
  void give_back(size_t pose_count) { (void)charge_.resize(charge_.amount() - bytes(pose_count)); }

  // Reserves capacity for `count` poses; the contents are lost. Returns false, with the vector unchanged, if
  // it exceeds the budget.
  bool reserve(std::vector<wire::Affine3x4>& poses, size_t count) {
    if (poses.capacity() >= count) return true;
    if (!take(count - poses.capacity())) return false;
    poses.clear();
    poses.reserve(count);
    return true;
  }

  size_t amount() const { return charge_.amount(); }

 private:
  static size_t bytes(size_t pose_count) { return pose_count * sizeof(wire::Affine3x4); }

  BudgetCharge charge_;
};

// Maximum number of simultaneously open frames of one stream: 0.25 s at 240 Hz, 1 s at 60 Hz.
inline constexpr size_t kMaxOpenFrames = 64;
// Maximum memory of open frames. kMinOpenFrames of them may exceed it, within the peer's budget.
inline constexpr size_t kMaxOpenFrameBytes = size_t{16} << 20;
inline constexpr size_t kMinOpenFrames = 4;

class FrameAssembler {
 public:
  enum class Outcome {
    whole,        // header() and poses() are the frame
    open,         // poses are missing
    stale,        // older than every open frame, or without new poses
    refused,      // contradicts earlier parts, or exceeds the frame
    over_budget,  // exceeds the peer's budget
  };

  FrameAssembler() = default;
  // Null: no limits.
  explicit FrameAssembler(std::shared_ptr<PeerBudget> budget) : memory_(std::move(budget)) {}

  // Precondition: the caller checked that `part` is newer than the displayed frame and has the stream's
  // node_count.
  Outcome add(const wire::PoseFrameView& part);

  // The whole frame of the last add(); valid until the next call.
  const wire::PoseFrameHeader& header() const { return whole_header_; }
  const std::vector<wire::Affine3x4>& poses() const { return whole_poses_; }

  // Closes the frames up to this sequence. Returns how many of them were older and incomplete.
  uint64_t close_up_to(uint64_t sequence) { return frames_.close_up_to(sequence); }
  // Closes the whole frame of this sequence, after the caller has stored it.
  void close(uint64_t sequence) { frames_.close(sequence); }
  // Number of frames dropped for newer ones since the last call.
  uint64_t take_given_up() { return frames_.take_given_up(); }

  // Frames of which a first part arrived, and those that became whole.
  uint64_t opened() const { return opened_; }
  uint64_t completed() const { return completed_; }

  // Bytes of poses that this object holds.
  size_t memory_bytes() const { return memory_.amount(); }

 private:
  static constexpr size_t kChunkPoses = 256;
  using Chunk = std::array<wire::Affine3x4, kChunkPoses>;
  static constexpr size_t kMaxChunks = kMaxOpenFrameBytes / sizeof(Chunk);
  struct OpenFrame {
    uint64_t sequence = 0;
    wire::PoseFrameHeader header;
    uint32_t node_count = 0;
    ElementSet arrived;                          // node indices
    std::vector<std::unique_ptr<Chunk>> chunks;  // null where no pose has arrived

    // Retains the chunks for the next frame in this slot.
    void clear() {
      arrived.clear();
      sequence = 0;
    }
  };
  OpenFrame* frame_of(const wire::PoseFrameView& part);
  Outcome make_chunks(OpenFrame& frame, size_t begin, size_t end);
  bool make_room(const OpenFrame& frame, size_t kept);
  void free_chunks(OpenFrame& frame);
  bool make_whole(const OpenFrame& frame);

  OpenFrames<OpenFrame, kMaxOpenFrames> frames_;
  size_t chunk_count_ = 0;  // of all open frames and free slots
  uint64_t opened_ = 0, completed_ = 0;
  wire::PoseFrameHeader whole_header_;
  std::vector<wire::Affine3x4> whole_poses_;
  PoseMemory memory_;
};

}  // namespace fire3dv::stream
