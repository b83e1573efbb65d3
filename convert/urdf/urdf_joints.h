// Joints of a URDF as the kinematic tree of a model.
#pragma once

#include <urdf_model/model.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "convert/model.h"

namespace fire3dv::convert {

// Adds the links, which are nodes already, and their joints, whose order is joint_names, and moves the nodes
// to where the joints rest: 0, or the nearest limit, or where the joints that they mimic put them.
// node_of_link: index into Model::nodes. warnings: receives what cannot be kept.
void add_urdf_joints(const urdf::ModelInterface& robot, const std::vector<std::string>& joint_names,
                     const std::map<std::string, size_t>& node_of_link, Model& model,
                     std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
