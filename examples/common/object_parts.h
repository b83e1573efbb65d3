// How an object looks, in its own frame.
#pragma once

#include <vector>

#include "examples/common/mesh.h"
#include "examples/common/object.h"

namespace examples {

std::vector<Part> object_parts(const Object& object);

}  // namespace examples
