// The files of materials that an OBJ mesh names. What reads OBJ for libmujoco opens them by itself, though it
// needs none of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::convert {

// As they stand in such a text. Readers differ in what a backslash before a blank means: names come in both
// readings. The error is the end of a sentence about it.
Result<std::vector<std::string>> obj_material_files(std::string_view text);

// Where that reader looks for such a file, for a mesh that it was told to read from `mesh`: in the folder
// before the last slash or backslash, which it takes for a list with colons.
std::vector<std::filesystem::path> obj_material_places(const std::string& mesh, const std::string& name);

}  // namespace fire3dv::convert
