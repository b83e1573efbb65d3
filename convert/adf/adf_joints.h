// Joints of AMBF models as the kinematic tree of a scene. AMBF's joints are constraints between bodies that
// are placed in the world; a body follows the first joint that names it as its child.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "convert/adf/adf_yaml.h"
#include "convert/joints.h"

namespace fire3dv::convert {

struct AdfJoint {
  std::string name, parent, child;  // bodies as the block names them
  std::string location;             // file and line, for warnings
  size_t file = 0;                  // model file that it is from
  Joint::Type type = Joint::Type::revolute;
  glm::dvec3 parent_pivot{0}, child_pivot{0};  // metres, without the scales of the bodies
  glm::dvec3 parent_axis{0, 0, 1}, child_axis{0, 0, 1};
  double offset_rad = 0;  // turns the child about the axis
  std::optional<std::pair<double, double>> limits;
};

struct AdfJointBody {
  std::string id, name;  // of the block and of the node
  size_t file = 0;
  size_t node = 0;
  double scale = 1;
  glm::dvec3 translation{0};  // in the world
  glm::dquat rotation{1, 0, 0, 0};
};

// Empty: the block is no joint that can be kept, which is reported.
std::optional<AdfJoint> read_adf_joint(const AdfFile::Block& block, size_t file);

// Bodies without joints are left out. Reports joints that are left out: of unknown bodies, and those that
// close a loop.
Kinematics adf_kinematics(const std::vector<AdfJoint>& joints, const std::vector<AdfJointBody>& bodies,
                          AdfReport& report);

}  // namespace fire3dv::convert
