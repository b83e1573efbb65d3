// Conversion of the equirectangular environment image to level 0 of the radiance cube.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment_pass.glsl"

layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_IN) uniform sampler2D background;

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  const vec3 direction = normalize(cube_direction(texel.z, face_point(texel.xy, int(push.size))));
  imageStore(level_out, texel, vec4(textureLod(background, equirectangular_uv(direction), push.lod).rgb, 1));
}
