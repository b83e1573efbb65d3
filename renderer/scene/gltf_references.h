// Every index of the file, used by the shown scene or not: a file that contradicts itself is refused as a
// whole.
#pragma once

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"

namespace fire3dv::scene {

Result<void> check_references(const GltfDocument& document);

}  // namespace fire3dv::scene
