// Materials and lights as the shaders read them.
#pragma once

#include <vector>

#include "renderer/scene/scene.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

gpu_types::MaterialRecord material_record(const scene::Material& material);
gpu_types::LightRecord light_record(const scene::Light& light, uint32_t node);

}  // namespace fire3dv::passes
