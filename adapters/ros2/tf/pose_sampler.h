// Pose frames from a transform buffer: which frames are nodes, the time that all of them share, and their
// poses in the fixed frame.
//
// Time: the oldest of the newest stamps of the frames that move, on the ways from the nodes to the fixed
// frame. Frames that were silent for a second keep their last transform and hold nobody up. Frames whose
// stamps are more than 10 s away from the others' have another clock: their newest transform counts.
//
// Nodes: a change of the set waits for 200 ms of quiet, two seconds at most, so that a start makes one
// description. A node that loses its path keeps its pose for two seconds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "adapters/ros2/tf/frames.h"

namespace fire3dv::ros2 {

struct PoseSamplerOptions {
  std::string fixed_frame;   // empty: map, odom, world, or the root with most nodes
  std::string frame_prefix;  // stripped from frame names; frames without it are no nodes
};

// Fault of one frame, for a message.
struct FrameFault {
  enum class Kind { unconnected, loop, other_clock, no_stamp };
  Kind kind;
  FrameId frame;
  FrameId other = kNoFrame;  // unconnected, loop: the root; other_clock: a frame of the clock that counts

  bool operator==(const FrameFault&) const = default;
};

class PoseSampler {
 public:
  explicit PoseSampler(PoseSamplerOptions options) : options_(std::move(options)) {}

  // Names of the robot's links: only they are nodes. Without them all frames are.
  void set_links(std::optional<std::vector<std::string>> links);
  // Time moved back: the next frame begins a new description and is a discontinuity.
  void restart();

  struct Frame {
    bool is_new_layout = false;  // node_names() have changed, or a restart: describe, then publish
    bool is_discontinuity = false;
    int64_t time_ns = 0;
  };
  // Returns a frame if there is a newer one. now_ns: monotonic clock.
  std::optional<Frame> update(FrameBuffer& buffer, int64_t now_ns);

  // Of the last frame: fixed_from_node, 3x4 row-major.
  const std::vector<std::array<float, 12>>& poses() const { return poses_; }
  const std::vector<std::string>& node_names() const { return names_; }
  FrameId fixed_frame() const { return layout_ ? layout_->fixed : kNoFrame; }

  // Faults that were not returned before. `patient`: also frames that are not connected (yet).
  std::vector<FrameFault> new_faults(const FrameBuffer& buffer, bool patient);

 private:
  struct Layout {
    FrameId fixed = kNoFrame;
    std::vector<FrameId> nodes;
    bool operator==(const Layout&) const = default;
  };

  std::vector<FrameId> wanted_nodes(const FrameBuffer& buffer) const;
  FrameId choose_fixed(const FrameBuffer& buffer, const std::vector<FrameId>& wanted);
  size_t count_connected(const FrameBuffer& buffer, FrameId fixed, const std::vector<FrameId>& wanted);
  Layout plan(const FrameBuffer& buffer);
  void consider(const FrameBuffer& buffer, int64_t now_ns);
  bool is_due(const FrameBuffer& buffer, int64_t now_ns);
  void adopt(const FrameBuffer& buffer);
  std::optional<int64_t> common_time(const FrameBuffer& buffer, const std::vector<FrameId>& moving,
                                     int64_t now_ns);
  void evaluate(const FrameBuffer& buffer, int64_t time_ns);

  PoseSamplerOptions options_;
  std::optional<std::vector<std::string>> links_;
  FrameTree tree_;
  std::optional<Layout> layout_, pending_;  // pending_: another layout that waits for quiet
  bool pending_shrinks_ = false;            // it lacks nodes of layout_
  int64_t pending_since_ns_ = 0, first_pending_ns_ = 0, next_plan_ns_ = 0;
  std::optional<uint64_t> planned_version_;
  bool restarts_ = false;
  std::vector<FrameId> moving_;
  uint64_t moving_version_ = 0, static_version_ = 0;
  std::optional<int64_t> last_time_ns_;
  std::vector<std::string> names_;
  std::vector<std::array<float, 12>> poses_;
  std::vector<int64_t> newest_;  // scratch of common_time()
  std::vector<FrameFault> reported_, clock_faults_;
};

}  // namespace fire3dv::ros2
