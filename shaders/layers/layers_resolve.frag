// Draws the composited layers over the surfaces behind them. Variants: FIRE3DV_SAMPLES 1 or 4. FIRE3DV_DUAL_SOURCE
// scales the background by a second colour; without it all channels pass their mean.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRE3DV_LAYER_FRAGMENT
#include "layers/layers.glsl"

layout(push_constant, scalar) uniform Push { LayerPush push; };
#ifdef FIRE3DV_DUAL_SOURCE
layout(location = 0, index = 0) out vec4 out_light;
layout(location = 0, index = 1) out vec4 out_behind;
#else
layout(location = 0) out vec4 out_light;
#endif

void main() {
  const LayerTarget target = LayerTargetRef(push.target).value;
  const uint pixel = layer_pixel(target);
  if (LayerKeyRef(target.states).at[pixel] == FIRE3DV_LAYERS_NONE) discard;
#if FIRE3DV_SAMPLES == 4
  const LayerSample layers = LayerSampleRef(target.samples).at[gl_SampleID * layer_pixels(target) + pixel];
#else
  const LayerSample layers = LayerSampleRef(target.samples).at[pixel];
#endif
  const vec4 behind = vec4(unpackHalf2x16(layers.behind[0]), unpackHalf2x16(layers.behind[1]));
  out_light = vec4(unpackHalf2x16(layers.light[0]), unpackHalf2x16(layers.light[1]));
#ifdef FIRE3DV_DUAL_SOURCE
  out_behind = behind;
#else
  out_light.a = 1 - behind.a;
#endif
}
