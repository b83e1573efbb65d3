// Visual meshes of an object with material names, in the object's frame.
#pragma once

#include <vector>

#include "examples/common/mesh.h"
#include "examples/common/object.h"

namespace examples {

std::vector<Part> object_parts(const Object& object);

}  // namespace examples
