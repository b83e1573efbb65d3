// Scene textures: bindless sampling with explicit derivatives.
#ifndef FIRE3DV_TEXTURES_GLSL
#define FIRE3DV_TEXTURES_GLSL
#extension GL_EXT_nonuniform_qualifier : require
#include "common/scene_variant.glsl"
#include "shared/bindings.h"

layout(set = 0, binding = FIRE3DV_BINDING_TEXTURES) uniform sampler2D scene_textures[];

// Transforms coordinates without their offset; also for derivatives.
vec2 turned_uv(TextureUse use, vec4 uv01) {
  const vec2 uv = kSecondUv && (use.texture & FIRE3DV_TEXTURE_SECOND_UV) != 0 ? uv01.zw : uv01.xy;
  return vec2(dot(use.uv_rows.xy, uv), dot(use.uv_rows.zw, uv));
}

vec2 texture_uv(TextureUse use, vec4 uv01) { return turned_uv(use, uv01) + use.uv_offset; }

// dx, dy: derivatives of both coordinate sets. Callers pass them, since compute shaders have no hardware
// derivatives.
vec4 sample_or(TextureUse use, vec4 uv01, vec4 dx, vec4 dy, vec4 without) {
  if (!kTextures || use.texture == FIRE3DV_NO_INDEX) return without;
  const vec2 uv = texture_uv(use, uv01), uv_dx = turned_uv(use, dx), uv_dy = turned_uv(use, dy);
  const uint number = use.texture & FIRE3DV_TEXTURE_NUMBER;
  if ((use.texture & FIRE3DV_TEXTURE_ANISOTROPIC) != 0) {
    return textureGrad(scene_textures[nonuniformEXT(number)], uv, uv_dx, uv_dy);
  }
  // Mip level as the specification defines it; devices only approximate that.
  const vec2 size = unpackHalf2x16(use.size);
  const vec2 along_x = uv_dx * size, along_y = uv_dy * size;
  const float level = 0.5 * log2(max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30));
  return textureLod(scene_textures[nonuniformEXT(number)], uv, level);
}

// For code without derivatives, such as the alpha test of a shadow ray.
vec4 sample_level0_or(TextureUse use, vec4 uv01, vec4 without) {
  if (use.texture == FIRE3DV_NO_INDEX) return without;
  return textureLod(scene_textures[nonuniformEXT(use.texture & FIRE3DV_TEXTURE_NUMBER)], texture_uv(use, uv01), 0);
}

#endif
