// import_mesh in a process of its own, with bounds on its time and memory: a file that makes the importer
// crash, hang or eat memory costs an error.
#pragma once

#include <filesystem>

#include "protocol/error.h"
#include "tools/convert/mesh_import.h"

namespace fire3dv::convert {

Result<ImportedMesh> import_mesh_in_child(const std::filesystem::path& file);

}  // namespace fire3dv::convert
