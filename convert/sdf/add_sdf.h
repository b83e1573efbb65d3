// Scene builder: turns SDF's entities into the nodes, meshes, lights and cameras of a model, as Gazebo shows
// them.
#pragma once

#include <filesystem>

#include "convert/model.h"
#include "convert/readers.h"
#include "convert/sdf/files/sdf_files.h"
#include "convert/sdf/sdf_scene.h"

namespace fire3dv::convert {

// Adds one node for each item, at the same index in an empty model, then those of lights and cameras. What
// cannot be drawn is left out, with a warning. file: for warnings; empty: a running world.
void add_sdf(const SdfScene& scene, const std::filesystem::path& file, const ReadOptions& options,
             SdfFiles& files, Model& model);

}  // namespace fire3dv::convert
