// Repair of surfaces from files to satisfy glTF.
#pragma once

#include <string>

#include "tools/convert/model.h"

namespace fire3dv::convert {

// Removes triangles with missing or non-finite vertices, and replaces invalid normals by those of adjacent
// triangles. Returns a description of the repairs, or "".
std::string repair(Surface& surface);

}  // namespace fire3dv::convert
