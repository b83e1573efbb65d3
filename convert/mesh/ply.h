// Reader of PLY files: triangles and polygons with normals and texture coordinates, in text and both binary
// forms. (assimp's reader does not return from damaged files.)
#pragma once

#include <string_view>

#include "base/error.h"
#include "convert/mesh/mesh_import.h"

namespace fire3dv::convert {

// bytes: contents of the file. The result has one default material.
Result<ImportedMesh> import_ply(std::string_view bytes, Nodes nodes = Nodes::merge);

}  // namespace fire3dv::convert
