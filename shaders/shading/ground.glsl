// Shadow catcher: a horizontal plane below the scene that darkens the background where lights are blocked. It is
// no geometry: outputs of numbers, rays and reflections ignore it. Shadows come from the shadow maps, so that
// techniques without maps leave it unshadowed. With FIRE3DV_PATH_TRACED the including shader traces them.
#ifndef FIRE3DV_GROUND_GLSL
#define FIRE3DV_GROUND_GLSL
#include "environment/environment.glsl"
#include "shading/lights.glsl"

#ifdef FIRE3DV_PATH_TRACED
float ground_visibility(GlobalsRef globals, uint light_index, LightSample light, vec3 position_world);
#else
#include "shading/shadow_maps.glsl"

// Mean of five filtered lookups, since texels of a map are larger than pixels near the camera.
float ground_visibility(GlobalsRef globals, uint light_index, LightSample light, vec3 position_world) {
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF || globals.value.light_views == 0) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  if (shadow.rays == 0) return 1;
  const vec3 up = vec3(0, 1, 0);
  const float step_m = 0.002 * globals.value.ground_radius_m;
  float sum = map_visibility(globals, shadow, position_world, up, light);
  for (int i = 0; i < 4; ++i) {
    const vec3 offset = step_m * vec3(i < 2 ? 1 : -1, 0, (i & 1) == 0 ? 0.5 : -0.5);
    sum += map_visibility(globals, shadow, position_world + offset, up, light);
  }
  return sum / 5;
}
#endif

// Factor on the background's radiance: irradiance of the plane with shadows over that without.
float ground_factor(GlobalsRef globals, vec3 direction) {
  const float radius_m = globals.value.ground_radius_m;
  const float below_m = globals.value.eye_world.y - globals.value.ground_height_m;
  if (radius_m <= 0 || below_m <= 0 || direction.y >= 0) return 1;
  const vec3 position = globals.value.eye_world - direction * (below_m / direction.y);
  const float fade = 1 - smoothstep(0.4, 1.0, distance(position.xz, globals.value.ground_center) / radius_m);
  if (fade <= 0) return 1;
  const vec3 luminance = vec3(0.2126, 0.7152, 0.0722), up = vec3(0, 1, 0);
  float whole = PI * dot(scattered_radiance(globals, up), luminance);
  float arriving = whole;
  for (uint i = 0; i < globals.value.light_count; ++i) {
    const LightSample light = sample_light(globals, i, position);
    const float irradiance = dot(light.irradiance, luminance) * max(light.to_light.y, 0);
    if (irradiance <= 0) continue;
    whole += irradiance;
    arriving += irradiance * ground_visibility(globals, i, light, position);
  }
  return whole > 0 ? mix(1, arriving / whole, fade) : 1;
}

#endif
