// The files of materials that an OBJ mesh names. What reads OBJ for libmujoco opens them by itself, though it
// needs none of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::convert {

bool is_obj(const std::filesystem::path& file);

// As they stand in such a text, relative to the mesh's folder whatever they begin with. Readers differ in
// what a backslash before a blank means: names come in both readings. The error is the end of a sentence
// about it.
Result<std::vector<std::string>> obj_material_files(std::string_view text);

}  // namespace fire3dv::convert
