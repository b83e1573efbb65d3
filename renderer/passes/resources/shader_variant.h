// Variants of shaders by the scene: specialisation constants (shaders/common/scene_variant.glsl).
#pragma once

#include <array>
#include <cstdint>

#include "renderer/passes/resources/gpu_scene.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/types.h"

namespace fire3dv::passes {

struct ShaderVariant {
  uint32_t shadows = FIRE3DV_SHADOWS_ANY;
  bool textures = true, masks = true, second_uv = true;
  bool several_worlds = false;                          // several views, or worlds, in one dispatch
  uint32_t material_flags = FIRE3DV_MATERIAL_OPTIONAL;  // of them those that a material has
  bool operator==(const ShaderVariant&) const = default;

  std::array<uint32_t, FIRE3DV_VARIANT_COUNT> constants() const {
    std::array<uint32_t, FIRE3DV_VARIANT_COUNT> values{};
    values[FIRE3DV_VARIANT_SHADOWS] = shadows;
    values[FIRE3DV_VARIANT_TEXTURES] = textures;
    values[FIRE3DV_VARIANT_MASKS] = masks;
    values[FIRE3DV_VARIANT_SECOND_UV] = second_uv;
    values[FIRE3DV_VARIANT_WORLDS] = several_worlds;
    values[FIRE3DV_VARIANT_MATERIAL_FLAGS] = material_flags;
    return values;
  }
};

// Variant of the shaders that trace rays and shade their hits: path tracing and ray effects.
struct RayVariant {
  bool extensions = true;  // selects another shader
  ShaderVariant shader;
  bool operator==(const RayVariant&) const = default;

  static RayVariant of(const GpuScene& scene) {
    return {scene.has_extensions,
            {FIRE3DV_SHADOWS_ANY, scene.has_textures, scene.has_masked, scene.has_second_uv, false,
             scene.material_flags}};
  }
};

}  // namespace fire3dv::passes
