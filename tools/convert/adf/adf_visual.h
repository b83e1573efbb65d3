// Appearance of ADF bodies: mesh files and built-in shapes, with materials of the file or colours of the
// body, by AMBF's precedence. Bodies of equal appearance share a mesh.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/convert/adf/adf_yaml.h"
#include "tools/convert/mesh/mesh_files.h"
#include "tools/convert/mesh/mesh_store.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Search folders for a block's mesh.
struct AdfSearchPaths {
  std::filesystem::path file_folder;  // folder of the model file
  std::string visual_path;            // the file's "high resolution path"
};

struct AdfAppearance {
  std::optional<size_t> mesh;
  bool mesh_is_missing = false;  // AMBF drops such bodies
};

class AdfVisuals {
 public:
  AdfVisuals(Model& model, size_t most_triangles)
      : model_(model), files_(model), store_(model, most_triangles) {}

  AdfAppearance appearance_of(const AdfValue& block, const std::string& name, const AdfSearchPaths& places);
  void allow_images_below(const std::filesystem::path& folder) { files_.allow_images_below(folder); }

 private:
  struct Color;
  Color color_of(const AdfValue& block) const;
  std::optional<std::vector<Surface>> file_surfaces(const AdfValue& block, const std::string& name,
                                                    const AdfSearchPaths& places, double scale);
  std::vector<Surface> shape_surfaces(const AdfValue& block, double scale);
  Surface shape_surface(const AdfValue& shape, const AdfValue& geometry, double scale);
  size_t colored(size_t material, const Color& color, const std::string& name);
  size_t plain_material();

  Model& model_;
  MeshFiles files_;
  MeshStore store_;
  std::map<std::string, std::optional<size_t>> meshes_;  // mesh files, keyed by everything that affects their
                                                         // appearance
  std::map<std::string, size_t> materials_;
  std::optional<size_t> plain_;
};

}  // namespace fire3dv::convert
