// The built-in surroundings: a neutral studio with a bright ceiling and a darker floor, in closed form, so that metals
// have something to reflect and shadows are not black.
#ifndef FIRE3DV_ENVIRONMENT_GLSL
#define FIRE3DV_ENVIRONMENT_GLSL
#include "common/brdf.glsl"

// Radiance from a direction, blurred by a lobe of the given perceptual roughness.
vec3 studio_radiance(vec3 direction, float roughness) {
  const float softness = mix(0.15, 1.0, roughness);
  const float up = smoothstep(-softness, softness, direction.y);
  const vec3 floor_color = vec3(0.30, 0.29, 0.28);
  const vec3 ceiling_color = vec3(1.10, 1.12, 1.15);
  // Two soft panels give polished metal its contrast; they fade as the lobe widens.
  const float panel = smoothstep(0.80 - 0.3 * roughness, 0.95, dot(direction, normalize(vec3(0.5, 0.6, 0.6)))) +
                      smoothstep(0.85 - 0.3 * roughness, 0.97, dot(direction, normalize(vec3(-0.8, 0.4, -0.1))));
  return mix(floor_color, ceiling_color, up) + panel * (1 - roughness) * vec3(1.5);
}

// Karis' approximation of the environment BRDF ("Physically Based Shading on Mobile", 2014).
vec3 environment_brdf(vec3 f0, float roughness, float n_dot_v) {
  const vec4 c0 = vec4(-1, -0.0275, -0.572, 0.022);
  const vec4 c1 = vec4(1, 0.0425, 1.04, -0.04);
  const vec4 r = roughness * c0 + c1;
  const float a004 = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
  const vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
  return f0 * ab.x + ab.y;
}

vec3 reflect_environment(Surface s, float occlusion) {
  const float n_dot_v = clamp(dot(s.normal, s.to_eye), 0, 1);
  const vec3 specular = environment_brdf(s.f0, s.roughness, n_dot_v) *
                        studio_radiance(reflect(-s.to_eye, s.normal), s.roughness);
  const vec3 diffuse = s.diffuse_color * studio_radiance(s.normal, 1);
  return (diffuse + specular) * occlusion;
}

#endif
