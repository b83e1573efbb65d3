// A model as one binary glTF 2.0 file: everything inside, images too.
#pragma once

#include <string>
#include <vector>

#include "protocol/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Surfaces without triangles, meshes without surfaces and what nothing uses are left out. The same model
// gives the same bytes. warnings: gets a sentence for each image that cannot be decoded and is left out, and
// for each surface that had to be repaired; may be null.
Result<std::vector<std::byte>> write_glb(const Model& model, std::vector<std::string>* warnings = nullptr);

}  // namespace fire3dv::convert
