#include "convert/joints.h"

#include <algorithm>

namespace fire3dv::convert {

bool Kinematics::has_joints() const {
  return std::any_of(joints.begin(), joints.end(),
                     [](const Joint& joint) { return joint.type != Joint::Type::fixed; });
}

size_t positions_of(Joint::Type type) {
  switch (type) {
    case Joint::Type::fixed:
      return 0;
    case Joint::Type::revolute:
    case Joint::Type::prismatic:
      return 1;
    case Joint::Type::planar:
      return 3;
    case Joint::Type::ball:
      return 4;
    case Joint::Type::floating:
      break;
  }
  return 7;
}

const char* name_of(Joint::Type type) {
  switch (type) {
    case Joint::Type::fixed:
      return "fixed";
    case Joint::Type::revolute:
      return "revolute";
    case Joint::Type::prismatic:
      return "prismatic";
    case Joint::Type::planar:
      return "planar";
    case Joint::Type::ball:
      return "ball";
    case Joint::Type::floating:
      break;
  }
  return "floating";
}

std::vector<std::string> drop_mimic_loops(std::vector<Joint>& joints) {
  std::vector<std::string> dropped;
  std::vector<size_t> walk_of(joints.size(), 0);
  for (size_t start = 0; start < joints.size(); ++start) {
    size_t at = start;
    while (walk_of[at] == 0 && joints[at].mimic) {
      walk_of[at] = start + 1;
      at = joints[at].mimic->joint;
    }
    if (!joints[at].mimic || walk_of[at] != start + 1) continue;
    dropped.push_back(joints[at].name);
    joints[at].mimic.reset();
  }
  return dropped;
}

}  // namespace fire3dv::convert
