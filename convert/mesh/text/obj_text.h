// Checked text of an OBJ file for assimp's reader, which loses numbers such as ".5", and faces that name
// missing texture coordinates or normals.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

struct ObjText {
  std::string text;
  std::vector<std::string> warnings;
};

// file: contents, UTF-8 or UTF-16. The result has whole lines: vertices and faces in one form, all indices
// counted from 1 and in range; lines and points are left out; others are as in the file. The error names the
// line.
Result<ObjText> checked_obj(std::string_view file);

}  // namespace fire3dv::convert
