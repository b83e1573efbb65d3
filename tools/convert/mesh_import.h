// One mesh file as assimp reads it, made into surfaces: the part of MeshFiles that touches assimp. Run it
// where its end does no harm (mesh_child.h): parsers of so many formats have faults.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// As the file says it: colours as displayed, images by the file's own names for them.
struct ImportedMaterial {
  std::string name;
  glm::vec3 diffuse{1}, emission{0};
  float opacity = 1;
  float roughness = 0.5f;
  std::string diffuse_image, normal_image;  // empty: none
};

struct ImportedMesh {
  std::vector<ImportedMaterial> materials;
  std::vector<Surface> surfaces;  // material: into materials
  Sources besides;                // further files that were read or looked for
};

// Formats by the file's name: obj, stl, 3ds, dae. Only these: each more is more that can be attacked.
bool is_mesh_file_name(const std::filesystem::path& file);

// `file` is a regular file; further files that it names (.mtl) are read only below its folder.
Result<ImportedMesh> import_mesh(const std::filesystem::path& file);

// Whether all indices are within bounds and all numbers finite. The error says what is not.
Result<void> check_imported(const ImportedMesh& mesh);

}  // namespace fire3dv::convert
