// Paths in the tree of frames: poses in the fixed frame at one time, and the moving frames on the way.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "protocol/frames/frame_buffer.h"

namespace fire3dv::frames {

// Solver of one tree after the other: begin(), then any number of frames. Memory is reused. Takes linear time
// in the number of frames; loops between frames and long chains are no problem.
class FrameTree {
 public:
  // time_ns: none: structure of the newest transforms. `fixed` may be any frame, not only a root.
  void begin(const FrameBuffer& buffer, FrameId fixed, std::optional<int64_t> time_ns);

  // fixed_from_frame; nullptr: no path. Valid until the next call.
  const Transform* find(FrameId frame);

  // True for a frame without a path that a loop of parents is to blame for.
  bool is_in_loop(FrameId frame) const;
  // The last frame on the way up from a frame without a path. A frame of the loop, if there is one.
  // roots: results of other frames since begin(), which make many calls take linear time together.
  FrameId root_of(FrameId frame, std::unordered_map<FrameId, FrameId>& roots) const;

  // Stamped frames between these frames and the fixed frame, each once, in the tree of the newest transforms.
  // Frames without a path are left out.
  std::vector<FrameId> moving_frames(const std::vector<FrameId>& frames);

 private:
  enum class State : uint8_t { open, known, none, loop };
  struct Node {
    uint64_t round = 0;  // of begin() that the state belongs to
    State state = State::open;
    bool is_on_path = false;
    bool is_collected = false;
    Transform fixed_from_frame;
  };

  Node& node(FrameId frame);
  const Frame& frame(FrameId id) const { return buffer_->frames()[id]; }
  FrameSample sample(const Frame& frame) const;

  const FrameBuffer* buffer_ = nullptr;
  FrameId fixed_ = kNoFrame;
  std::optional<int64_t> time_ns_;
  uint64_t round_ = 0;
  std::vector<Node> nodes_;
  std::vector<FrameId> ancestors_;  // of the fixed frame, nearest first
  std::vector<std::pair<FrameId, Transform>> path_;
};

}  // namespace fire3dv::frames
