// Irradiance cube: cosine-weighted mean of one small level of the radiance cube. The sum includes every
// texel, so that the sun is not missed.
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRE3DV_PACKED_RADIANCE
#include "environment/environment_pass.glsl"

layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_ABOVE, rgba16f) uniform readonly image2DArray radiance;

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  const vec3 normal = normalize(cube_direction(texel.z, face_point(texel.xy, int(push.size))));
  const int size = imageSize(radiance).x;
  vec4 sum = vec4(0);
  for (int face = 0; face < 6; ++face) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const vec2 p = face_point(ivec2(x, y), size);
        const float cosine = dot(normal, normalize(cube_direction(face, p)));
        if (cosine > 0) sum += cosine * texel_solid_angle(p) * vec4(imageLoad(radiance, ivec3(x, y, face)).rgb, 1);
      }
    }
  }
  put_radiance(texel, sum.rgb / sum.a);
}
