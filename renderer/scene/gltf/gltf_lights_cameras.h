// Loader of KHR_lights_punctual lights and glTF cameras, in file order.
#pragma once

#include "protocol/base/error.h"
#include "renderer/scene/gltf/gltf_document.h"
#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

Result<void> add_lights(const GltfDocument& document, Scene& scene);
Result<void> add_cameras(const GltfDocument& document, Scene& scene);

}  // namespace fire3dv::scene
