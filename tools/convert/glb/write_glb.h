// Writer of a Model as one self-contained binary glTF 2.0 file (GLB), images included.
#pragma once

#include <string>
#include <vector>

#include "protocol/base/error.h"
#include "tools/convert/model.h"

namespace fire3dv::convert {

// Skips empty surfaces and meshes, and unused elements. Equal models give equal bytes. warnings: receives a
// message per undecodable image and per repaired surface; may be null.
Result<std::vector<std::byte>> write_glb(const Model& model, std::vector<std::string>* warnings = nullptr);

}  // namespace fire3dv::convert
