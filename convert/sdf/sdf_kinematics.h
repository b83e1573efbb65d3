// Joints of an SDF scene as the kinematic tree of a model.
#pragma once

#include <string>
#include <vector>

#include "convert/model.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// model: has a node for each item, at the same index. Bodies are the links that joints connect. A joint keeps
// its name, or is MODEL/NAME where several have it; the second axis of a universal joint is NAME#2. Positions
// are 0 where the file places the links.
void add_sdf_kinematics(const SdfScene& scene, Model& model, std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
