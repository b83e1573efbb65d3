// Mesh import through assimp: one file to surfaces. Run it in a child process (mesh_child.h), since parsers
// of this many formats have memory faults.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Material as in the file: displayed (sRGB) colours, image names of the file.
struct ImportedMaterial {
  std::string name;
  glm::vec3 diffuse{1}, emission{0};
  float opacity = 1;
  float roughness = 0.5f;
  std::string diffuse_image, normal_image;  // empty: none
};

struct ImportedMesh {
  std::vector<ImportedMaterial> materials;
  std::vector<Surface> surfaces;  // material: index into materials
  Sources besides;                // further files that were read or requested
};

// Accepts obj, stl, 3ds and dae by file name. The list is short to keep the attack surface small.
bool is_mesh_file_name(const std::filesystem::path& file);

// file: regular file. Files that it references (.mtl) must lie below its folder.
Result<ImportedMesh> import_mesh(const std::filesystem::path& file);

// Checks that all indices are in bounds and all numbers finite.
Result<void> check_imported(const ImportedMesh& mesh);

}  // namespace fire3dv::convert
