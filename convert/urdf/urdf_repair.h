// Repairs of a URDF before urdfdom reads it: values that urdfdom refuses, with the whole robot, though they
// do not matter for drawing and other tools accept them.
#pragma once

#include <tinyxml2.h>

#include <string>
#include <vector>

namespace fire3dv::convert {

// Changes the elements below <robot> and returns a note for each kind of change that the user should know.
// - A mesh scale of one number is that of all axes.
// - A robot without a name gets `name`.
// - Revolute and prismatic joints without <limit> rest at 0; a limit without effort or velocity gets 0.
// - A <material> without a name gets one, and a colour of three numbers is opaque.
// - <inertial>, <transmission> and <gazebo> are removed.
std::vector<std::string> repair_urdf(tinyxml2::XMLElement& robot, const std::string& name);

}  // namespace fire3dv::convert
