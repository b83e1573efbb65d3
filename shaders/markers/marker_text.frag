// Colour of a glyph of a text marker, display-referred like marker.frag. Coverage is the distance to the glyph's
// outline, by the signed distance field in the atlas.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "markers/marker_output.glsl"
#include "shared/glyph_types.h"

layout(location = 0) in vec4 in_color;
layout(location = 1) in vec2 in_texel;

float value_at(ivec2 texel) {
  const uint index = uint(texel.y) * FIRE3DV_GLYPH_ATLAS_WIDTH + uint(texel.x);
  return float(UintRef(push.sizes).at[index / 4] >> (8 * (index % 4)) & 0xffu);
}

void main() {
  const bool is_shown = begin_marker(15);
  // Texts are upright and not distorted.
  const float texels_per_pixel = max(length(dFdx(in_texel)), 1e-6);
  // Samples at the edge of a rectangle may lie outside.
  const vec2 last = vec2(FIRE3DV_GLYPH_ATLAS_WIDTH - 1, push.segments - 1);
  const vec2 at = clamp(in_texel - 0.5, vec2(0), last - 1);
  const ivec2 low = ivec2(at);
  const vec2 share = at - vec2(low);
  const float value = mix(mix(value_at(low), value_at(low + ivec2(1, 0)), share.x),
                          mix(value_at(low + ivec2(0, 1)), value_at(low + ivec2(1, 1)), share.x), share.y);
  const float inside_texels = (value - FIRE3DV_GLYPH_ON_EDGE) / FIRE3DV_GLYPH_VALUES_PER_TEXEL;
  const float alpha = in_color.a * clamp(inside_texels / texels_per_pixel + 0.5, 0, 1);
  if (!is_shown) discard;  // fragments without colour draw it, since a layer may wait for it
  draw_marker(vec4(in_color.rgb * alpha, alpha));
}
