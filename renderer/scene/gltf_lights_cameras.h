// KHR_lights_punctual's lights and glTF's cameras, in the file's order.
#pragma once

#include "protocol/error.h"
#include "renderer/scene/gltf_document.h"
#include "renderer/scene/scene.h"

namespace fire3dv::scene {

Result<void> add_lights(const GltfDocument& document, Scene& scene);
Result<void> add_cameras(const GltfDocument& document, Scene& scene);

}  // namespace fire3dv::scene
