// Transforms of a robot's links by joint states, in the frame of its root link.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/frames/transform.h"
#include "protocol/import/messages/messages.h"
#include "protocol/robot/robot.h"

namespace fire3dv::imported {

class LinkPoses {
 public:
  // robot: borrowed; at least one body. prefix: before the links' names in those of frames. is_in_degrees:
  // positions of joints that turn.
  LinkPoses(robot::Robot& robot, const std::string& prefix, bool is_in_degrees = false);

  // Frames of the links; the root first.
  const std::vector<std::string>& frames() const { return frames_; }
  // Joints with one position that follow no other.
  bool has_joint(const std::string& name) const { return joints_.contains(name); }
  const std::map<std::string, size_t>& joints() const { return joints_; }
  // Ignores joints that the robot lacks, and positions that are not finite.
  void set(const std::string& joint, double position);
  // Largest position of a joint that turns, if more than half of at least two such joints went beyond a whole
  // turn in radians: the positions may be in degrees.
  std::optional<double> largest_beyond_turn() const;
  // root_from_link of links 1 to the last.
  std::vector<TransformSample> transforms(int64_t time_ns);
  // Pose of the root link in the robot's frame.
  frames::Transform model_from_root() { return pose(0); }

 private:
  frames::Transform pose(size_t body);

  robot::Robot& robot_;
  std::vector<std::string> frames_;
  std::map<std::string, size_t> joints_;
  double radians_from_unit_ = 1;
  std::map<size_t, double> largest_;  // absolute position of joints that turn, as given
};

}  // namespace fire3dv::imported
