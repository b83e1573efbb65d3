// Colour of a marker, display-referred: the target's alpha, the share of scene-referred light, becomes less.
// Variants: FIRE3DV_DISC cuts points to discs. FIRE3DV_SAMPLES=4 covers the samples inside the disc. FIRE3DV_LAYERS
// and FIRE3DV_LAYER_KEYS: see marker_output.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "markers/marker_output.glsl"

layout(location = 0) in vec4 in_color;
layout(location = 1) in vec2 in_disc;

void main() {
  uint inside = 15;
#ifdef FIRE3DV_DISC
  const vec2 dx = dFdxFine(in_disc), dy = dFdyFine(in_disc);
#ifdef FIRE3DV_SAMPLES
  // Standard sample positions.
  const vec2 offsets[4] = vec2[4](vec2(-0.125, -0.375), vec2(0.375, -0.125), vec2(-0.375, 0.125), vec2(0.125, 0.375));
  inside = 0;
  for (int s = 0; s < 4; ++s) {
    precise vec2 at = in_disc + dx * offsets[s].x + dy * offsets[s].y;  // the same bits in all variants
    precise float squared = at.x * at.x + at.y * at.y;
    if (squared <= 1) inside |= 1u << s;
  }
#else
  if (dot(in_disc, in_disc) > 1) inside = 0;
#endif
#ifndef FIRE3DV_LAYERS
  if (inside == 0) discard;
  gl_SampleMask[0] = int(inside);
#endif
#endif
  if (begin_marker(inside)) draw_marker(vec4(in_color.rgb * in_color.a, in_color.a));
}
