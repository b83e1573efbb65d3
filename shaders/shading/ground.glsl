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

// Lit and known share of the four texels around a point of the plane, with bilinear weights. A caster that is nearer to
// the plane than the map resolves (a body's foot) is unknown: it may be above the point or beside it.
vec2 known_light(GlobalsRef globals, RasterView view, vec3 position_world, LightSample light) {
  const ShadowMapPoint at = shadow_map_point(view, position_world);
  if (!at.inside) return vec2(1);
  const float unresolved_m = 1.5 * slope_m(at, vec3(0, 1, 0), light.to_light);
  const FilterTexels texels = filter_texels(globals, at);
  const vec4 lit = vec4(lessThan(texels.at, uvec4(encoded_nearer_by(globals, at, -unresolved_m))));
  const vec4 shadowed = vec4(greaterThanEqual(texels.at, uvec4(encoded_nearer_by(globals, at, unresolved_m))));
  return vec2(filtered(texels, lit), filtered(texels, lit + shadowed));
}

// Mean of the known texels of five filtered lookups, since texels of a map are larger than pixels near the camera.
float ground_visibility(GlobalsRef globals, uint light_index, LightSample light, vec3 position_world) {
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF || globals.value.light_views == 0) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  if (shadow.rays == 0 || shadow.view_count == 0) return 1;
  const RasterView view = view_of(globals, shadow, light);
  const float step_m = 0.002 * globals.value.ground_radius_m;
  vec2 sum = known_light(globals, view, position_world, light);
  for (int i = 0; i < 4; ++i) {
    const vec3 offset = step_m * vec3(i < 2 ? 1 : -1, 0, (i & 1) == 0 ? 0.5 : -0.5);
    sum += known_light(globals, view, position_world + offset, light);
  }
  return sum.y > 1e-3 ? min(sum.x / sum.y, 1) : 0;
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
#ifdef FIRE3DV_PATH_TRACED
  const uint sun = globals.value.environment_sun;
  if (sun != FIRE3DV_NO_INDEX) {  // its light is part of the environment's
    const LightSample light = sample_light(globals, sun, position);
    const float irradiance = min(dot(light.irradiance, luminance) * max(light.to_light.y, 0), whole);
    if (irradiance > 0) arriving -= irradiance * (1 - ground_visibility(globals, sun, light, position));
  }
#endif
  return whole > 0 ? mix(1, arriving / whole, fade) : 1;
}

#ifndef FIRE3DV_PATH_TRACED
vec3 direction_at(GlobalsRef globals, vec2 position) {
  const vec2 ndc = position / vec2(globals.value.width, globals.value.height) * 2 - 1;
  return globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y + globals.value.world_from_ndc_origin;
}

// Radiance of a pixel's background: sampled at the centre, but the shadow at the mean of the visible samples, since the
// plane at the centre may lie under a body. center, offset: in pixels.
vec3 background_of(GlobalsRef globals, vec2 center, vec2 offset) {
  const vec3 radiance = background_radiance(globals, direction_at(globals, center));
  if (globals.value.ground_radius_m <= 0) return radiance;
  return radiance * ground_factor(globals, direction_at(globals, center + offset));
}
#endif

#endif
