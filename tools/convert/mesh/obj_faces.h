// Index validation of OBJ meshes. libmujoco's OBJ parser does not check the indices of faces, lines and
// points and would read out of bounds.
#pragma once

#include <string_view>

#include "protocol/base/error.h"

namespace fire3dv::convert {

// text: contents of the file. The error is the end of a sentence about it.
Result<void> check_obj_faces(std::string_view text);

}  // namespace fire3dv::convert
