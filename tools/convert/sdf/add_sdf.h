// Scene builder: turns the contents of an SDF file into the nodes, meshes, lights and cameras of a model.
#pragma once

#include <filesystem>

#include "tools/convert/model.h"
#include "tools/convert/readers.h"
#include "tools/convert/sdf/files/sdf_files.h"
#include "tools/convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// file: for warnings.
void add_sdf(const SdfScene& scene, const std::filesystem::path& file, const ReadOptions& options,
             SdfFiles& files, Model& model);

}  // namespace fire3dv::convert
