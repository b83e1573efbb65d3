// Reader of STL files, text and binary: triangles, solids and their names, colours of VisCAM and Magics.
// Files whose counts or ends are wrong are read as far as they go, with a warning.
#pragma once

#include <string_view>

#include "base/error.h"
#include "convert/mesh/mesh_import.h"

namespace fire3dv::convert {

// bytes: contents of the file. The result has one default material and no normals: those of STL are the
// triangles', and often wrong.
Result<ImportedMesh> import_stl(std::string_view bytes, Nodes nodes = Nodes::merge);

}  // namespace fire3dv::convert
