// Adds the level below to a level of the bloom chain, in place: a mix, so that energy is conserved.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "post/bloom.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { BloomUpPush push; };
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D level_below;
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform image2D level;

void main() {
  const ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(texel, imageSize(level)))) return;
  const vec4 light = mix(imageLoad(level, texel), enlarged(level_below, texel), push.share_of_level_below);
  imageStore(level, texel, vec4(round_to_halves(light.rgb), round_to_halves(light.aaa).x));
}
