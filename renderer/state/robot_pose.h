// Robot of the displayed scene's file, posed by joint positions: rest poses of the nodes of its bodies.
// Single-threaded.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "protocol/robot/robot.h"
#include "renderer/scene/model/scene.h"
#include "renderer/state/motion/animation.h"
#include "renderer/state/node_index.h"

namespace fire3dv::state {

// Positions of joints that follow no other, by the joint's index; the others keep the positions of the file.
// Numbers as of robot::Robot: radians, metres, unit quaternions x y z w.
using JointPositions = std::map<size_t, std::vector<double>>;

class RobotPose {
 public:
  explicit RobotPose(robot::Robot robot);

  const robot::Robot& robot() const { return robot_; }
  // True for joints with a position of one number: revolute or prismatic, and following no other.
  bool is_scalar(size_t joint) const;
  // Nodes of the bodies, after the scene was loaded or replaced.
  void set_scene(const scene::Scene& scene, const NodeNames& names);
  // Scene node that the joint moves, or scene::kNone.
  uint32_t node_of(size_t joint) const;

  // Invalid entries are ignored, and positions are clamped to the limits. Returns true if the pose has
  // changed.
  bool set(const JointPositions& positions);
  // True if a joint has left the position of the file.
  bool is_moved() const { return !positions_.empty(); }
  const JointPositions& positions() const { return positions_; }
  // The positions of robot().named_poses()[pose].
  JointPositions positions_of(size_t pose) const;
  // Places the bodies' nodes and all nodes below them. pose: a rest pose of the scene.
  void apply(RestPose& pose);

 private:
  robot::Robot robot_;
  std::vector<double> home_;
  JointPositions positions_;
  std::vector<uint32_t> node_of_body_;  // scene::kNone: the scene has no such node
  std::vector<size_t> body_of_node_;    // SIZE_MAX: no body
  std::vector<uint32_t> parents_;       // of the scene's nodes, which precede their children
};

}  // namespace fire3dv::state
