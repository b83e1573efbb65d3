// Checks of OBJ meshes before libmujoco reads them. Its OBJ parser does not check the indices of faces, lines
// and points and would read out of bounds. It also opens material files (MTL), though it needs none of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::convert {

// text: contents of the file. The error is the end of a sentence about it.
Result<void> check_obj_faces(std::string_view text);

// Returns the names in the text. Parsers differ on a backslash before a blank, so both readings are included.
// The error is the end of a sentence about the file.
Result<std::vector<std::string>> obj_material_files(std::string_view text);

// Returns the paths that the parser tries for a mesh at `mesh`: in the folder before the last slash or
// backslash, which it splits at colons.
std::vector<std::filesystem::path> obj_material_paths(const std::string& mesh, const std::string& name);

}  // namespace fire3dv::convert
