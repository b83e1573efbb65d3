// Surfaces as files give them, made such that glTF allows them.
#pragma once

#include <string>

#include "tools/convert/model.h"

namespace fire3dv::convert {

// Leaves out triangles with vertices that do not exist or are nowhere (not finite), and gives normals that
// are not of length 1 the direction of the triangles around. What was wrong, or nothing.
std::string repair(Surface& surface);

// `name` as valid UTF-8 without control characters; what is neither is replaced by '?'.
std::string valid_utf8(const std::string& name);

}  // namespace fire3dv::convert
