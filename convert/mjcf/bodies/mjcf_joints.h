// Joints and linear joint couplings of an MJCF model as the kinematic tree of a scene.
#pragma once

#include "convert/joints.h"
#include "convert/mjcf/bodies/mjcf_tree.h"

namespace fire3dv::convert {

// Joints have MuJoCo's order; one without a name is "joint_N", N its index. coordinates: of the pose in the
// scene. Body::node: index into the tree's bodies; the world is left out. Warns of couplings that are not
// linear.
Kinematics mjcf_kinematics(const MjcfTree& tree, const MjcfCoordinates& coordinates);

// Positions of the joints of mjcf_kinematics(), in their order.
std::vector<double> mjcf_positions(const MjcfTree& tree, const MjcfCoordinates& coordinates);

}  // namespace fire3dv::convert
