// The points of a pixel that shadow rays start from: one for each surface that its samples show, on the triangle of the
// surface's first sample, in the middle of the surface's samples.
#ifndef FIRE3DV_SHADOW_POINTS_GLSL
#define FIRE3DV_SHADOW_POINTS_GLSL
#include "common/lights.glsl"
#include "common/ray_offset.glsl"
#include "common/visible_triangle.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleRef { uvec2 at[]; };  // id, depth

struct PixelParts {
  uint id[FIRE3DV_SAMPLES];    // of each sample; 0 = background
  uint part[FIRE3DV_SAMPLES];  // FIRE3DV_NO_INDEX = background
  uint group[FIRE3DV_SAMPLES]; // the first sample of the same surface
};

vec3 plane_of_id(GlobalsRef globals, uint id) {
  const VisibleTriangle t = visible_triangle(globals, id);
  const vec3 normal = cross(t.world[1] - t.world[0], t.world[2] - t.world[0]);
  return dot(normal, normal) > 0 ? normalize(normal) : vec3(0);
}

// Triangles of one part that face nearly the same way.
bool same_surface(GlobalsRef globals, PixelParts parts, int one, int other) {
  if (parts.id[one] == parts.id[other]) return true;
  if (parts.part[one] != parts.part[other]) return false;
  return dot(plane_of_id(globals, parts.id[one]), plane_of_id(globals, parts.id[other])) > 0.9;
}

PixelParts pixel_parts(GlobalsRef globals, uint64_t visibility, uint pixel) {
  PixelParts parts;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    parts.id[s] = SampleRef(visibility).at[pixel * FIRE3DV_SAMPLES + s].x;
    parts.part[s] = parts.id[s] == 0 ? FIRE3DV_NO_INDEX : part_of_id(globals, parts.id[s]);
    parts.group[s] = s;
    for (int earlier = 0; earlier < s; ++earlier) {
      if (parts.group[earlier] != earlier || !same_surface(globals, parts, earlier, s)) continue;
      parts.group[s] = earlier;
      break;
    }
  }
  return parts;
}

// Samples of this one's surface, as bits; 0 when an earlier sample stands for it.
uint samples_of_surface(PixelParts parts, int first) {
  if (parts.id[first] == 0 || parts.group[first] != first) return 0;
  uint same = 0;
  for (int s = first; s < FIRE3DV_SAMPLES; ++s) {
    if (parts.group[s] == first) same |= 1u << s;
  }
  return same;
}

SurfacePoint shadow_point(GlobalsRef globals, PixelParts parts, int first, uint same, uint pixel, out uint part) {
  vec2 middle = vec2(0);
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    if ((same & (1u << s)) != 0) middle += vec2(kSamplePosition[s]) / kSubpixels;
  }
  middle /= bitCount(same);
  part = parts.part[first];
  const vec2 corner = vec2(pixel % globals.value.width, pixel / globals.value.width);
  return surface_point(globals, visible_triangle(globals, parts.id[first]), corner + middle);
}

// Whether light from there can make a difference: to a surface without a normal map only from before it.
bool light_matters(GlobalsRef globals, SurfacePoint point, LightSample light) {
  if (max(light.irradiance.r, max(light.irradiance.g, light.irradiance.b)) <= 0) return false;
  if (MaterialRef(globals.value.materials).at[point.material].normal_texture.texture != FIRE3DV_NO_INDEX) return true;
  return dot(point.normal_world, light.to_light) > 0;
}

struct ShadowRay {
  vec3 origin;
  LightSample light;  // as it is seen from there
};

// Off the surface on the side that the light is on, so that thin sheets lit from behind are not taken for their own
// shadow. Maps are asked about the same ray that is traced where they cannot tell.
ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, LightRecord record, LightSample light) {
  const vec3 normal = point.plane_normal_world;
  const vec3 side = dot(normal, light.to_light) < 0 ? -normal : normal;
  ShadowRay ray;
  ray.origin = offset_from_surface(point.position_world, side, globals.value.eye_world, point.pixel_size_m);
  ray.light = sample_light(record, AffineRowsRef(globals.value.world_from_node).at[record.node], ray.origin);
  return ray;
}

#endif
