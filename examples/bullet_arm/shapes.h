// Visual meshes of the arm's links with material names, in link frames, metres.
#pragma once

#include <cstddef>
#include <vector>

#include "examples/common/mesh.h"

namespace bullet_arm {

std::vector<examples::Part> arm_parts(size_t index);  // index: as in kArmNames

}  // namespace bullet_arm
