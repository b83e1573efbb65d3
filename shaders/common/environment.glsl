// The surroundings as light: prepared once for all roughnesses (environment_*.comp), looked up here.
#ifndef FIRE3DV_ENVIRONMENT_GLSL
#define FIRE3DV_ENVIRONMENT_GLSL
#include "common/brdf.glsl"
#include "common/buffers.glsl"
#include "common/directions.glsl"
#include "shared/bindings.h"

layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_PICTURE) uniform sampler2D environment_picture;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_SPECULAR) uniform samplerCube environment_specular;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_IRRADIANCE) uniform samplerCube environment_irradiance;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_ALBEDO) uniform sampler2D environment_albedo;

// --environment-rotation turns the surroundings about +Y, counter-clockwise seen from above; so a look-up turns back.
vec3 environment_from_world(GlobalsRef globals, vec3 direction) {
  const float c = globals.value.environment_turn.x, s = globals.value.environment_turn.y;
  return vec3(c * direction.x - s * direction.z, direction.y, s * direction.x + c * direction.z);
}

// The level that holds a roughness; the other way round in environment.cpp.
vec3 reflected_radiance(GlobalsRef globals, vec3 direction, float roughness) {
  const float level = roughness * (2 - roughness) * float(textureQueryLevels(environment_specular) - 1);
  return globals.value.environment_intensity *
         textureLod(environment_specular, environment_from_world(globals, direction), level).rgb;
}

// Of a white matte surface.
vec3 scattered_radiance(GlobalsRef globals, vec3 normal) {
  return globals.value.environment_intensity *
         textureLod(environment_irradiance, environment_from_world(globals, normal), 0).rgb;
}

// What is seen where there is nothing else.
vec3 background_radiance(GlobalsRef globals, vec3 direction) {
  if (globals.value.background_lod < 0) return globals.value.background;
  const vec2 uv = equirectangular_uv(normalize(environment_from_world(globals, direction)));
  return globals.value.environment_intensity * textureLod(environment_picture, uv, globals.value.background_lod).rgb;
}

Lobe make_lobe(vec3 normal, vec3 to_eye, float roughness, vec3 f0, float f90) {
  Lobe lobe;
  lobe.normal = normal;
  lobe.roughness = clamp(roughness, 0, 1);
  lobe.alpha = max(lobe.roughness * lobe.roughness, LEAST_ALPHA);
  lobe.n_dot_v = clamp(dot(normal, to_eye), 1e-4, 1);
  lobe.f0 = f0;
  lobe.f90 = f90;
  const vec2 split = textureLod(environment_albedo, vec2(lobe.n_dot_v, lobe.roughness), 0).rg;
  lobe.gain = 1 + f0 * (1 / (split.x + split.y) - 1);
  lobe.albedo = (f0 * split.x + f90 * split.y) * lobe.gain;
  return lobe;
}

float sheen_albedo_of(float n_dot_v, float roughness) {
  return textureLod(environment_albedo, vec2(n_dot_v, roughness), 0).b;
}

vec3 reflect_environment_lobe(GlobalsRef globals, Lobe lobe, vec3 to_eye) {
  return lobe.albedo * reflected_radiance(globals, reflect(-to_eye, lobe.normal), lobe.roughness);
}

vec3 reflect_environment(GlobalsRef globals, Surface s, float occlusion) {
  const vec3 scattered = scattered_radiance(globals, s.base.normal);
  vec3 result = reflect_environment_lobe(globals, s.base, s.to_eye) + (1 - largest(s.base.albedo)) * s.diffuse * scattered;
  if (largest(s.sheen_color) > 0) {
    // The fibres' lobe is as wide as a hemisphere, so the matte look-up serves it too.
    result *= 1 - largest(s.sheen_color) * s.sheen_albedo;
    result += s.sheen_color * s.sheen_albedo * scattered;
  }
  if (s.coat > 0) {
    result *= 1 - s.coat * s.coat_lobe.albedo.r;
    result += s.coat * reflect_environment_lobe(globals, s.coat_lobe, s.to_eye);
  }
  return result * occlusion;
}

#endif
