// Meshes from the files that descriptions name: OBJ with MTL, STL, 3DS and DAE.
// Vertices stay in the file's frame: no axis is swapped. A file is read once for all that ask for it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "protocol/error.h"
#include "tools/convert/local_files.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Surfaces of materials that the file itself gives, and which are added to the model when first read.
class MeshFiles {
 public:
  explicit MeshFiles(Model& model);
  ~MeshFiles();

  // Images are read next to the mesh file that names them and below it, and below such folders.
  void allow_images_below(const std::filesystem::path& folder);
  void allow_images_below(const AllowedFolders& folders);

  // The surfaces of all that the file shows, polygons cut into triangles, lines and points left out, its own
  // nodes' transforms applied, `scale` applied to positions. Each surface's material is one of the file's
  // (index into model.materials; v of uvs and images as Model says). Images that are missing are warned of
  // and left out. The error names the file and says why.
  Result<std::vector<Surface>> surfaces(const std::filesystem::path& file,
                                        const glm::dvec3& scale = glm::dvec3(1));

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace fire3dv::convert
