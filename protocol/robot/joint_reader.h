// Reader of joint positions from the poses of a robot's bodies: the inverse of Robot::poses().
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "protocol/robot/robot.h"

namespace fire3dv::robot {

// Names of all positions in the order of Robot::positions(): "elbow", or "base.x" of joints with several
// numbers.
std::vector<std::string> position_names(const Robot& robot);

class JointReader {
 public:
  // Fails for a body with several joints that move it, whose positions its pose does not tell apart.
  static Result<JointReader> make(const Robot& robot);

  // position_names() of the robot: joints that follow others have none.
  const std::vector<std::string>& names() const { return names_; }
  size_t bodies() const { return bodies_.size(); }
  // Pose of a body whose parent has this one (model_from_body; ignored without a parent), with its joints at
  // their references.
  Transform rest_pose(size_t body, std::span<const Transform> model_from_body) const;
  // model_from_body: rigid, of all bodies in the order of Robot::bodies(). Appends one number for each name:
  // radians and metres, quaternions x y z w with w >= 0. An angle lies within the limits, if it can, else
  // above -pi and at most pi.
  void read(std::span<const Transform> model_from_body, std::vector<double>& positions) const;

 private:
  explicit JointReader(const Robot& robot) : bodies_(robot.bodies()), joints_(robot.joints()) {}

  std::vector<RobotBody> bodies_;
  std::vector<RobotJoint> joints_;
  std::vector<size_t> read_;  // joints with names
  std::vector<std::string> names_;
};

}  // namespace fire3dv::robot
