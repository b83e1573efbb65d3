// Meshes that MuJoCo generates from a few numbers.
#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "convert/mjcf/assets/mesh_data.h"

namespace fire3dv::convert {

// kind, parameters: as the attributes builtin and params. A wedge has points only, whose convex hull it is.
// The error is a sentence end about the mesh.
Result<MeshData> builtin_mesh(const std::string& kind, const std::vector<double>& parameters);

}  // namespace fire3dv::convert
