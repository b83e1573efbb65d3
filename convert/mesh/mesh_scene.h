// Mesh files as scenes: OBJ with MTL, STL, PLY, DAE and 3MF. Nodes, names, materials and vertex colours of
// the file are kept. Scales of its nodes are in the vertices, so that streams can pose them.
#pragma once

#include <filesystem>

#include "base/error.h"
#include "convert/model.h"
#include "convert/readers.h"

namespace fire3dv::convert {

// By file extension.
bool is_mesh_scene_name(const std::filesystem::path& file);

// Files are read in a child process with limits on time and memory. Without normals, STL is flat; others are
// smooth over edges below 37 degrees. The error names the file and the reason.
Result<Model> read_mesh_scene(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace fire3dv::convert
