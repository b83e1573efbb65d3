// First reading of a recording: all coordinate frames with their parents and first transforms, and the
// joints.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "protocol/frames/frame_buffer.h"
#include "protocol/import/batches.h"

namespace fire3dv::imported {

// Coordinate frame that is somebody's child.
struct SeenFrame {
  bool is_child = false, is_static = false;
  bool moves = false;     // has two times or more
  TransformSample first;  // with the lowest time
  std::string origin;     // topic and message of the first transform, for texts
};

class Survey {
 public:
  Survey() { buffer_.set_oldest_time(INT64_MAX); }  // the newest transforms suffice
  // Fails for frames that change their parents more often than any robot does.
  Result<void> add(const Batch& batch);
  // Adds a link of a robot, whose transform follows from joints.
  void add_link(const TransformSample& first);

  // Newest structure.
  const frames::FrameBuffer& buffer() const { return buffer_; }
  // By frame id; a root has the default.
  const std::vector<SeenFrame>& frames() const { return seen_; }
  // Child and parent, of all times.
  const std::set<std::pair<frames::FrameId, frames::FrameId>>& edges() const { return edges_; }
  // First position of each joint, and their lowest time.
  const std::map<std::string, double>& joints() const { return joints_; }
  int64_t first_joint_ns() const { return first_joint_ns_; }
  Faults& faults() { return faults_; }

 private:
  Result<void> add_transform(const Batch& batch, const TransformSample& sample);
  SeenFrame& seen(frames::FrameId id);

  frames::FrameBuffer buffer_;
  std::vector<SeenFrame> seen_;
  std::set<std::pair<frames::FrameId, frames::FrameId>> edges_;
  std::map<std::string, double> joints_;
  int64_t first_joint_ns_ = INT64_MAX;
  Faults faults_;
};

}  // namespace fire3dv::imported
