// Whether an OBJ mesh has all that its faces, lines and points name. What reads OBJ for libmujoco does not
// look, and would read beyond the end of what there is.
#pragma once

#include <string_view>

#include "protocol/error.h"

namespace fire3dv::convert {

// The error is the end of a sentence about the file with this text.
Result<void> check_obj_faces(std::string_view text);

}  // namespace fire3dv::convert
