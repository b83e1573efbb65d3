// Prefiltered specular cube of one roughness, for a view along the normal (Karis 2013). Importance-sampled
// GGX half vectors read a mip level that matches the sample density (Krivanek and Colbert 2008).
#version 460
#extension GL_GOOGLE_include_directive : require
#define FIRE3DV_PACKED_RADIANCE
#include "environment/environment_pass.glsl"

layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_IN) uniform samplerCube radiance;

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  const vec3 normal = normalize(cube_direction(texel.z, face_point(texel.xy, int(push.size))));
  if (push.roughness == 0) {
    put_radiance(texel, textureLod(radiance, normal, 0).rgb);
    return;
  }
  const float pi = 3.14159265358979;
  const float alpha = push.roughness * push.roughness, a2 = alpha * alpha;
  const float texels_per_sample = 4 * 6 * float(textureSize(radiance, 0).x) * float(textureSize(radiance, 0).x) /
                                  (4 * pi * push.samples);  // 4: each sample covers more than its share
  const mat3 world_from_local = frame_around(normal);
  vec4 sum = vec4(0);
  for (uint i = 0; i < push.samples; ++i) {
    const vec2 u = hammersley(i, push.samples);
    const float cos2 = (1 - u.y) / (1 + (a2 - 1) * u.y);  // of the half vector
    const float cos_h = sqrt(cos2), sin_h = sqrt(max(1 - cos2, 0));
    const float n_dot_l = 2 * cos2 - 1;
    if (n_dot_l <= 0) continue;
    const vec3 half_vector = vec3(sin_h * cos(2 * pi * u.x), sin_h * sin(2 * pi * u.x), cos_h);
    const vec3 to_light = 2 * cos_h * half_vector - vec3(0, 0, 1);
    const float d = cos2 * (a2 - 1) + 1;
    const float density = a2 / (4 * pi * d * d);  // of samples, per unit of solid angle
    const float lod = 0.5 * log2(texels_per_sample / density);
    sum += n_dot_l * vec4(textureLod(radiance, world_from_local * to_light, max(lod, 0)).rgb, 1);
  }
  put_radiance(texel, sum.rgb / sum.a);
}
