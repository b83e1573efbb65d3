// Downsampling of one radiance cube level from the larger one, weighted by solid angle so that energy is
// conserved.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment_pass.glsl"

layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_ABOVE, rgba16f) uniform readonly image2DArray level_above;

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  vec4 sum = vec4(0);
  for (int i = 0; i < 4; ++i) {
    const ivec2 above = 2 * texel.xy + ivec2(i & 1, i >> 1);
    sum += texel_solid_angle(face_point(above, 2 * int(push.size))) *
           vec4(imageLoad(level_above, ivec3(above, texel.z)).rgb, 1);
  }
  imageStore(level_out, texel, vec4(sum.rgb / sum.a, 1));
}
