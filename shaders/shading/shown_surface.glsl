// Surface of a pixel for output planes and picking, as outputs_pass.h defines it: the surface at the pixel's
// centre. With four samples, no sample lies there. The primitive instance with most samples wins. Ties select
// the nearest one with a triangle over the centre, then the background, then the first sample.
#ifndef FIRE3DV_SHOWN_SURFACE_GLSL
#define FIRE3DV_SHOWN_SURFACE_GLSL
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"

#define kInfinity uintBitsToFloat(0x7f800000u)

// Camera parameters that the globals lack.
struct Eye {
  uint64_t visibility;
  vec3 look_world;
  uint orthographic;
};

// Surface of a pixel.
struct ShownSurface {
  uint id;  // 0: background
  vec2 position;
  float depth_m;  // along the view direction
};

vec3 ray_through(GlobalsRef globals, vec2 position) {
  const vec2 ndc = position / vec2(globals.value.width, globals.value.height) * 2 - 1;
  return globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
         globals.value.world_from_ndc_origin;
}

// Depth of the view ray's intersection with the triangle's plane, clamped to the triangle's depth range.
// Raster vertices are snapped to a grid, so the ray at a grazing edge pixel may miss the triangle.
float depth_at(GlobalsRef globals, Eye eye, VisibleTriangle t, vec2 position) {
  const vec3 a = t.world[0] - globals.value.eye_world, b = t.world[1] - globals.value.eye_world,
             c = t.world[2] - globals.value.eye_world;
  const vec3 depths = vec3(dot(a, eye.look_world), dot(b, eye.look_world), dot(c, eye.look_world));
  const float nearest = min(depths.x, min(depths.y, depths.z)), farthest = max(depths.x, max(depths.y, depths.z));
  float depth_m;
  if (eye.orthographic != 0) {
    depth_m = dot(depths, barycentrics_at(t, position, vec2(globals.value.width, globals.value.height)));
  } else {
    // Use the nearest vertex: vertices of a floor that reaches to the horizon are less precise.
    const vec3 corner = depths.x == nearest ? a : depths.y == nearest ? b : c;
    const vec3 normal = cross(b - a, c - a);
    depth_m = dot(normal, corner) / dot(normal, ray_through(globals, position));
  }
  if (isnan(depth_m) || isinf(depth_m)) depth_m = nearest > 0 ? nearest : farthest;
  return clamp(depth_m, nearest, farthest);
}

#if FIRE3DV_SAMPLES == 4
// Samples of the most frequent primitive instances, as a bit mask.
uint most_of(uvec4 parts) {
  uint most = 0;
  int most_count = 0;
  for (int s = 0; s < 4; ++s) {
    const int count = bitCount(samples_with(parts, parts[s]));
    if (count < most_count) continue;
    most = count > most_count ? 1u << s : most | (1u << s);
    most_count = count;
  }
  return most;
}

// Fallback where no triangle covers the pixel's centre: the mean position of the samples. Perspective depths
// of a plane are linear in their inverses, so the mean uses those.
ShownSurface shown_by_samples(GlobalsRef globals, Eye eye, uvec2 pixel, PixelIds ids, uint samples) {
  float sum = 0;
  for (int s = 0; s < 4; ++s) {
    if ((samples & (1u << s)) == 0) continue;
    const vec2 position = vec2(pixel) + vec2(kSamplePosition[s]) / kSubpixels;
    const float depth_m = depth_at(globals, eye, visible_triangle(globals, id_of_sample(ids, s)), position);
    sum += eye.orthographic != 0 ? depth_m : 1 / depth_m;
  }
  const float mean = sum / bitCount(samples);
  return ShownSurface(id_of_sample(ids, findLSB(samples)), position_of_samples(pixel, samples),
               eye.orthographic != 0 ? mean : 1 / mean);
}

ShownSurface shown_by_most(GlobalsRef globals, Eye eye, uvec2 pixel, PixelIds ids) {
  const vec2 center = vec2(pixel) + 0.5, size = vec2(globals.value.width, globals.value.height);
  uvec4 parts = uvec4(FIRE3DV_NO_INDEX);
  for (int s = 0; s < 4; ++s) {
    if (id_of_sample(ids, s) != 0) parts[s] = part_of_id(globals, id_of_sample(ids, s));
  }
  const uint candidates = most_of(parts);
  ShownSurface shown = ShownSurface(0, center, kInfinity);
  uint open = candidates;
  while (open != 0) {
    const uint id = id_of_sample(ids, findLSB(open));
    open &= ~samples_with(ids, id);
    if (id == 0) continue;
    const VisibleTriangle t = visible_triangle(globals, id);
    const vec3 b = barycentrics_at(t, center, size);
    if (min(b.x, min(b.y, b.z)) < 0) continue;
    const float depth_m = depth_at(globals, eye, t, center);
    if (depth_m < shown.depth_m) shown = ShownSurface(id, center, depth_m);
  }
  const bool has_background = (candidates & samples_with(parts, FIRE3DV_NO_INDEX)) != 0;
  if (shown.id != 0 || has_background) return shown;
  return shown_by_samples(globals, eye, pixel, ids, samples_with(parts, parts[findLSB(candidates)]));
}
#endif

ShownSurface shown_in(GlobalsRef globals, Eye eye, uvec2 pixel) {
  const vec2 center = vec2(pixel) + 0.5;
  const PixelIds ids = pixel_ids(globals, eye.visibility, pixel.y * globals.value.width + pixel.x);
  const uint id = id_of_sample(ids, 0);
#if FIRE3DV_SAMPLES == 4
  if (samples_with(ids, id) != kAllSamples) return shown_by_most(globals, eye, pixel, ids);
#endif
  if (id == 0) return ShownSurface(0, center, kInfinity);
  return ShownSurface(id, center, depth_at(globals, eye, visible_triangle(globals, id), center));
}

// Shading normal without normal maps, on the visible side.
vec3 normal_of(GlobalsRef globals, ShownSurface shown) {
  return surface_point(globals, visible_triangle(globals, shown.id), shown.position).normal_world;
}

#endif
