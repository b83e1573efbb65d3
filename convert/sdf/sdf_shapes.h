// Surfaces of the visuals of an SDF scene.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "convert/mesh/mesh_files.h"
#include "convert/model.h"
#include "convert/readers.h"
#include "convert/sdf/files/sdf_files.h"
#include "convert/sdf/sdf_materials.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// Rotation from +Z to the normal of a plane; empty for a normal without a direction.
std::optional<glm::dquat> plane_rotation(const SdfShape& plane);

class SdfShapes {
 public:
  // options: rotations of DAE and glTF meshes.
  SdfShapes(SdfFiles& files, const ReadOptions& options, SdfMaterials& materials, Model& model);

  // Adds the surfaces of a visual to its mesh. The error is a reason without the name of the visual.
  Result<void> add(const SdfItem& visual, Mesh& mesh);
  // Losses of the visuals since the last call.
  std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

 private:
  Result<void> add_mesh(const SdfItem& visual, Mesh& mesh);
  Result<void> add_polylines(const SdfItem& visual, Mesh& mesh);

  SdfFiles& files_;
  SdfMaterials& materials_;
  MeshFiles mesh_files_;
  std::vector<std::string> notes_;
  size_t polyline_points_ = 0;  // of all visuals
};

}  // namespace fire3dv::convert
