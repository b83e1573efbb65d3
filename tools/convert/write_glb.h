// A model as one binary glTF 2.0 file: everything inside, images too.
#pragma once

#include <filesystem>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Surfaces without triangles and meshes without surfaces are left out. The same model gives the same bytes.
Result<std::vector<std::byte>> write_glb(const Model& model);

}  // namespace fire3dv::convert
