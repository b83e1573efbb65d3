// Traces the rays of one entry of the list. The shader that includes this defines is_shadowed().
#ifndef FIRE3DV_TRACE_ENTRY_GLSL
#define FIRE3DV_TRACE_ENTRY_GLSL
#include "common/shadow_points.glsl"

bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m);

// An angle that differs from pixel to pixel but not from frame to frame (Jimenez 2014, interleaved gradient noise).
float turn_of_pixel(GlobalsRef globals, uint pixel) {
  const vec2 place = vec2(pixel % globals.value.width, pixel / globals.value.width);
  return 6.2831853 * fract(52.9829189 * fract(dot(place, vec2(0.06711056, 0.00583715))));
}

// Rays to points spread evenly over the light's disc (Vogel's spiral); how many arrive.
uint rays_that_arrive(GlobalsRef globals, vec3 origin, LightRecord record, LightSample light, uint rays, float turn) {
  const vec3 helper = abs(light.to_light.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0);
  const vec3 right = normalize(cross(helper, light.to_light)), up = cross(light.to_light, right);
  const bool directional = record.type == FIRE3DV_LIGHT_DIRECTIONAL;
  const float radius = directional ? tan(record.angular_radius_rad) : record.radius_m / light.distance_m;
  uint arrived = 0;
  for (uint k = 0; k < rays; ++k) {
    const float angle = turn + 2.3999632 * k, r = radius * sqrt((k + 0.5) / rays);
    const vec3 direction = light.to_light + r * (cos(angle) * right + sin(angle) * up);
    const float stretch = length(direction);
    if (!is_shadowed(globals, origin, direction / stretch, light.distance_m * stretch)) ++arrived;
  }
  return arrived;
}

void trace_entry(GlobalsRef globals, uint64_t visibility, RayEntry entry) {
  const PixelParts parts = pixel_parts(globals, visibility, entry.pixel);
  uint lit = 0;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    const uint same = samples_of_surface(parts, s);
    if (same == 0) continue;
    uint part;
    const SurfacePoint point = shadow_point(globals, parts, s, same, entry.pixel, part);
    for (uint i = 0; i < globals.value.light_count; ++i) {
      const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[i];
      const uint bit = 1u << (shadow.rays == 1 ? shadow.mask_shift + s : s);
      if (shadow.mask_word != entry.word || (entry.wanted & bit) == 0) continue;
      const LightRecord record = LightRef(globals.value.lights).at[i];
      const LightSample light =
          sample_light(record, AffineRowsRef(globals.value.world_from_node).at[record.node], point.position_world);
      const ShadowRay ray = shadow_ray(globals, point, record, light);
      if (shadow.rays == 1) {
        if (!is_shadowed(globals, ray.origin, ray.light.to_light, ray.light.distance_m)) lit |= same << shadow.mask_shift;
      } else {
        const uint arrived = rays_that_arrive(globals, ray.origin, record, ray.light, shadow.rays,
                                              turn_of_pixel(globals, entry.pixel));
        for (int other = 0; other < FIRE3DV_SAMPLES; ++other) {
          if ((same & (1u << other)) != 0) lit |= (arrived * 255 / shadow.rays) << (8 * other);
        }
      }
    }
  }
  // The word belongs to this entry alone.
  if (lit != 0) UintsRef(globals.value.shadow_mask).at[entry.pixel * globals.value.mask_words + entry.word] |= lit;
}

#endif
