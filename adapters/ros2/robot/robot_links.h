// Links of a converted robot, and their poses by joint positions: the task of robot_state_publisher, for
// systems that have none.
#pragma once

#include <fire3dv/joints.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "adapters/ros2/robot/joint_scalars.h"
#include "adapters/ros2/tf/frames.h"
#include "base/error.h"

namespace fire3dv::ros2 {

class RobotLinks {
 public:
  // glb: output of fire3dv-convert.
  static Result<RobotLinks> read(std::span<const uint8_t> glb);

  // Scene nodes of the links; the root first.
  const std::vector<std::string>& names() const { return names_; }
  // Offset of a node with a scale, by link; nullptr: none has one.
  const std::array<float, 12>* body_from_node(const std::string& link) const;

  // Of all joints, those that follow others included.
  const JointTypes& joint_types() const { return joint_types_; }
  // Sets the position of a revolute or prismatic joint. False: no such joint, or it follows another one, or
  // the position is not finite.
  bool set_joint(const std::string& joint, double position);
  // root_from_link of links 1 to the last, in the order of names().
  Result<std::vector<Transform>> root_from_links();

 private:
  struct Close {
    void operator()(fire3dv_robot* robot) const { fire3dv_close_robot(&robot); }
  };
  std::unique_ptr<fire3dv_robot, Close> robot_;
  std::vector<std::string> names_;
  std::unordered_map<std::string, std::array<float, 12>> offsets_;
  std::unordered_map<std::string, size_t> joints_;
  JointTypes joint_types_;
};

}  // namespace fire3dv::ros2
