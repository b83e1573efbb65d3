// Index validation of a whole glTF file, including unused objects. An inconsistent file is refused.
#pragma once

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"

namespace fire3dv::scene {

Result<void> check_references(const GltfDocument& document);

}  // namespace fire3dv::scene
