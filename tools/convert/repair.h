// Surfaces as files give them, made such that glTF allows them.
#pragma once

#include <string>

#include "tools/convert/model.h"

namespace fire3dv::convert {

// Leaves out triangles with vertices that do not exist or are nowhere (not finite), and gives normals that
// are not of length 1 the direction of the triangles around. What was wrong, or nothing.
std::string repair(Surface& surface);

}  // namespace fire3dv::convert
