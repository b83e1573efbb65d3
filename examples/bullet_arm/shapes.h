// How the links of the arm look: their parts, in each link's frame.
#pragma once

#include <cstddef>
#include <vector>

#include "examples/common/mesh.h"

namespace bullet_arm {

std::vector<examples::Part> arm_parts(size_t index);  // in the order of kArmNames

}  // namespace bullet_arm
