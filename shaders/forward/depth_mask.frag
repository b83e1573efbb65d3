// Depth pass of alpha-masked surfaces. Variant: FIRE3DV_SAMPLES=4 tests alpha at the mean of the covered
// samples.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "common/mean_sample_position.glsl"

layout(push_constant, scalar) uniform Push { ForwardPush push; };

layout(location = 3) in vec4 in_uv;
layout(location = 4) in vec4 in_color;
layout(location = 5) flat in uint in_material;

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[in_material];
  vec4 uv = in_uv, color = in_color;
#ifdef FIRE3DV_SAMPLES
  const vec2 offset = mean_sample_position(uint(gl_SampleMaskIn[0]));
  uv = interpolateAtOffset(in_uv, offset);
  color = interpolateAtOffset(in_color, offset);
#endif
  const vec4 texel = sample_or(material.base_color_texture, uv, dFdxFine(in_uv), dFdyFine(in_uv), vec4(1));
  if (material.base_color.a * color.a * texel.a < material.alpha_cutoff) discard;
}
