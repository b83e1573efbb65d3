// Specialisation constants of a pipeline (shaders/common/scene_variant.glsl).
#pragma once

#include <array>
#include <cstdint>

#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct ShaderVariant {
  uint32_t shadows = FIRE3DV_SHADOWS_ANY;
  bool textures = true, masks = true, second_uv = true;

  std::array<uint32_t, FIRE3DV_VARIANT_COUNT> constants() const {
    std::array<uint32_t, FIRE3DV_VARIANT_COUNT> values{};
    values[FIRE3DV_VARIANT_SHADOWS] = shadows;
    values[FIRE3DV_VARIANT_TEXTURES] = textures;
    values[FIRE3DV_VARIANT_MASKS] = masks;
    values[FIRE3DV_VARIANT_SECOND_UV] = second_uv;
    return values;
  }
};

}  // namespace fire3dv::passes
