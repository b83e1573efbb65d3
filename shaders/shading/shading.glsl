// Shading of a surface point: outgoing radiance towards the eye, shared by all raster paths.
#ifndef FIRE3DV_SHADING_GLSL
#define FIRE3DV_SHADING_GLSL
#include "material/material_surface.glsl"
#ifdef FIRE3DV_RAY_EFFECTS
#include "ray_effects/ray_effect_lookup.glsl"
#endif
#include "shading/lights.glsl"

// Visible share of a light at the point, 0 to 1. The including shader defines it.
float light_visibility(uint light_index, LightSample light, SurfacePoint point);

#ifdef FIRE3DV_LIGHT_OF_HIT
// Reflected light of all lamps and the environment. The including shader defines it. environment: unoccluded.
vec3 light_of_hit(GlobalsRef globals, Surface surface, SurfacePoint point, vec3 environment);
#endif

vec3 reflected_of_light(uint index, LightSample light, Surface surface, SurfacePoint point) {
  const vec3 reflected = reflect_light(surface, light.to_light, light.sine, is_above_surface(point, light.to_light)) * light.irradiance;
  return largest(reflected) <= 0 ? vec3(0) : reflected * light_visibility(index, light, point);
}

#ifdef FIRE3DV_CPU
const uint kCachedLights = 2;
LightPose cached_lights[kCachedLights];  // the first lights

// Call it before lanes diverge.
void hold_lights(GlobalsRef globals) {
  if (globals.value.light_count == 0) return;
  for (uint i = 0; i < kCachedLights; ++i) {
    cached_lights[i] = light_for_all(globals.value.light_poses, min(i, globals.value.light_count - 1));
  }
}
#endif

bool is_display_referred;  // of the last call of shade(): the colour is shown as it is

// Linear HDR colour, premultiplied, and alpha. to_eye: unit. behind: transmittance of the background, per channel.
vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point, vec3 to_eye,
           out vec3 behind) {
  const float kLargestHalf = 65504;  // largest finite half float of the target; larger values become
                                     // infinity, then NaN
  float alpha = 1;
  if ((material.flags & FIRE3DV_MATERIAL_BLEND) != 0) alpha = clamp(base_color.a, 0, 1);
  if ((material.flags & FIRE3DV_MATERIAL_MASK) != 0) alpha = base_color.a >= material.alpha_cutoff ? 1 : 0;
  behind = vec3(1 - alpha);
  is_display_referred = (material.flags & FIRE3DV_MATERIAL_UNLIT) != 0;
  if (is_display_referred) return vec4(min(base_color.rgb, vec3(kLargestHalf)) * alpha, alpha);

  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  const Surface surface = make_surface(globals, material, base_color, point, to_eye);
  const float occlusion_sample = sample_or(material.occlusion_texture, uv, dx, dy, vec4(1)).r;
  float occlusion = 1 + material.occlusion_strength * (occlusion_sample - 1);
#ifdef FIRE3DV_RAY_EFFECTS
  occlusion *= ray_effect.open;
#endif
  const float under_coat = surface.coat > 0 ? 1 - coat_albedo(surface) : 1;
  vec3 radiance = under_coat * material.emissive * sample_or(material.emissive_texture, uv, dx, dy, vec4(1)).rgb;
#ifdef FIRE3DV_LIGHT_OF_HIT
  radiance += light_of_hit(globals, surface, point, reflect_environment(globals, surface, occlusion));
#else
#ifdef FIRE3DV_RAY_EFFECTS
  radiance += reflect_environment(globals, surface, scattered_traced(globals, surface, occlusion, ray_effect), occlusion);
  radiance = max(radiance + reflect_traced(globals, surface, occlusion, ray_effect), vec3(0));
  if (kDiffuseTransmission) radiance += occlusion * pass_environment(globals, surface);
#else
  radiance += reflect_environment(globals, surface, occlusion);
#endif

  uint i = 0;
#ifdef FIRE3DV_CPU
  const vec3 position = point.position_world;
  if (globals.value.light_count > 0) {
    radiance += reflected_of_light(0, sample_light(cached_lights[0], position), surface, point);
  }
  if (globals.value.light_count > 1) {
    radiance += reflected_of_light(1, sample_light(cached_lights[1], position), surface, point);
  }
  i = kCachedLights;
#endif
  for (; i < globals.value.light_count; ++i) {
    radiance += reflected_of_light(i, sample_light(globals, i, point.position_world), surface, point);
  }
#endif

  if (largest(surface.transmitted) > 0) {
    const float under_sheen = largest(surface.sheen_color) > 0 ? 1 - largest(surface.sheen_color) * surface.sheen_albedo : 1;
    behind += alpha * under_coat * under_sheen * (1 - surface.body_albedo) * surface.transmitted;
  }
  // The alpha serves users that blend by one value: the mean over the channels.
  return vec4(min(radiance, vec3(kLargestHalf)) * alpha, 1 - dot(behind, vec3(1.0 / 3.0)));
}

vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point, out vec3 behind) {
  const vec3 to_eye = normalize(globals.value.eye_world - point.position_world);
  return shade(globals, material, base_color, point, to_eye, behind);
}

vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point) {
  vec3 behind;
  return shade(globals, material, base_color, point, behind);
}

#endif
