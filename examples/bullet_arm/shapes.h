// How each body looks: the parts of an object or of a link of the arm, in the body's frame.
#pragma once

#include <vector>

#include "examples/bullet_arm/layout.h"
#include "examples/bullet_arm/mesh.h"

namespace bullet_arm {

std::vector<Part> object_parts(const Object& object);
std::vector<Part> arm_parts(size_t index);  // in the order of kArmNames

}  // namespace bullet_arm
