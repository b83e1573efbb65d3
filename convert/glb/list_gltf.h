// List of the nodes of a glTF file, as fire3dv names them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::convert {

// By the extension: .glb, .gltf.
bool is_gltf_name(const std::filesystem::path& file);

// One line a node, indented by its depth: name, then separated by tabs what it carries ("12 triangles",
// "camera", "light"). A node without a name is "-". warnings: receives those of the file.
Result<std::vector<std::string>> list_gltf(const std::filesystem::path& file,
                                           std::vector<std::string>& warnings);

}  // namespace fire3dv::convert
