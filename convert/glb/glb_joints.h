// Joints of a model as glTF extras (docs/joints.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/joints.h"

namespace tinygltf {
class Value;
}

namespace fire3dv::convert {

// Extras of the root node. node_names: as in the file, by index into Model::nodes. Empty: the model has no
// joints, or one that cannot be written; warnings receives the reason then.
std::optional<tinygltf::Value> joint_extras(const Kinematics& kinematics,
                                            const std::vector<std::string>& node_names,
                                            std::vector<std::string>& warnings);

// One line for each joint: name, type, node, limits, and the joint that it follows, separated by tabs.
std::vector<std::string> joint_lines(const Kinematics& kinematics,
                                     const std::vector<std::string>& node_names);

}  // namespace fire3dv::convert
