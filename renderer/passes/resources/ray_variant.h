// Variant of the shaders that trace rays and shade their hits: path tracing and ray effects.
#pragma once

#include <array>
#include <cstdint>

#include "renderer/passes/resources/gpu_scene.h"
#include "shaders/shared/bindings.h"

namespace fire3dv::passes {

struct RayVariant {
  bool extensions = true, textures = true, second_uv = true, masked = true;
  uint32_t material_flags = 0;
  bool operator==(const RayVariant&) const = default;

  static RayVariant of(const GpuScene& scene) {
    return {scene.has_extensions, scene.has_textures, scene.has_second_uv, scene.has_masked,
            scene.material_flags};
  }
  // Of specialisation; `extensions` selects another shader.
  std::array<uint32_t, FIRE3DV_VARIANT_COUNT> constants() const {
    return {FIRE3DV_SHADOWS_ANY, textures ? 1u : 0u, masked ? 1u : 0u, second_uv ? 1u : 0u, material_flags};
  }
};

}  // namespace fire3dv::passes
