// Mesh file loader for descriptions: OBJ with MTL, STL, PLY, 3DS, DAE and glTF. Vertices stay in the file's
// frame without axis conversion. Each file is read once.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/error.h"
#include "convert/description_files.h"
#include "convert/mesh/mesh_import.h"
#include "convert/model.h"

namespace fire3dv::convert {

// Cache of surfaces by file. Materials are added to the model on first use.
class MeshFiles {
 public:
  explicit MeshFiles(Model& model);
  ~MeshFiles();

  // Images may lie next to the mesh file or below its folder, and below these folders.
  void allow_images_below(const std::filesystem::path& folder);
  void allow_images_below(const AllowedFolders& folders);

  // Rotates DAE files by their up_axis. Without it the axes are the file's.
  void apply_dae_up();
  // Rotates glTF files from +Y up to +Z up. Without it the axes are the file's.
  void apply_gltf_up();
  // Angle between faces, in degrees, up to which meshes without normals are smooth; 0: flat. Empty: 37.
  // Normals of STL files count as none.
  void set_smooth_angle(std::optional<double> angle_deg);
  // True for a material of the model that stands for none in a mesh file.
  bool is_default(size_t material) const;

  // Returns all surfaces of the file: triangulated, without lines and points, with node transforms applied
  // and positions scaled. material indexes model.materials. Missing images cause warnings. The error names
  // the file and the reason.
  Result<std::vector<Surface>> surfaces(const std::filesystem::path& file,
                                        const glm::dvec3& scale = glm::dvec3(1));

  // Returns the surfaces of the nodes, or else of the nodes' meshes, of that name, as surfaces() does. The
  // error names the nodes that there are.
  Result<std::vector<Surface>> surfaces_of_node(const std::filesystem::path& file, const std::string& name);

  // Returns the file as a scene: nodes, and surfaces with vertex colours in the frames of their nodes. DAE
  // files are Z up and in metres. Materials as above.
  Result<ImportedMesh> scene(const std::filesystem::path& file);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::convert
