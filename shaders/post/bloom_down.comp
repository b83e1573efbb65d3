// Next level of the bloom chain, half as wide and high: the quadratic B-spline 1 3 3 1 in each direction. Each texel
// adds up to a quarter in the next level, so that the chain conserves energy. Texels outside of the image have no light
// and, in alpha, no weight.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D level_above;
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform writeonly image2D result;

void main() {
  const ivec2 texel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(level_above, 0);
  if (any(greaterThanEqual(texel, imageSize(result)))) return;
  vec4 sum = vec4(0);
  for (int y = -1; y <= 2; ++y) {
    for (int x = -1; x <= 2; ++x) {
      const ivec2 from = 2 * texel + ivec2(x, y);
      if (any(lessThan(from, ivec2(0))) || any(greaterThanEqual(from, size))) continue;
      const float weight = (x == 0 || x == 1 ? 3 : 1) * (y == 0 || y == 1 ? 3 : 1) / 64.0;
      sum += weight * texelFetch(level_above, from, 0);
    }
  }
  imageStore(result, texel, vec4(round_to_halves(sum.rgb), round_to_halves(sum.aaa).x));
}
