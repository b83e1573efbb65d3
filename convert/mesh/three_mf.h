// Reader of 3MF files: objects, components and build items with unit, names, base materials, colour groups
// and textures, also of the production extension's further model files.
#pragma once

#include <filesystem>

#include "base/error.h"
#include "convert/mesh/mesh_import.h"

namespace fire3dv::convert {

// In metres, Z up, with nodes. The error has the reason without the file's name.
Result<ImportedMesh> import_3mf(const std::filesystem::path& file);

}  // namespace fire3dv::convert
