// Where a shadow ray starts.
#ifndef FIRE3DV_SHADOW_RAY_GLSL
#define FIRE3DV_SHADOW_RAY_GLSL
#include "common/lights.glsl"
#include "common/surface_point.glsl"

// A point off the surface, far enough that rounding cannot put the origin below it: the error of an interpolated
// position is a few units in the last place of its largest coordinate or of its distance to the eye, and near an edge a
// fraction of a pixel. So the offset scales with the scene and the view: a needle seen from 0.1 m gets about 1e-5 m.
// lift_m: that much more, less than a pixel, where the eye sees a coarser level than the one that rays meet.
vec3 offset_from_surface(vec3 position_world, vec3 geometric_normal, vec3 eye_world, float pixel_size_m, float lift_m) {
  const vec3 size = max(abs(position_world), abs(position_world - eye_world));
  const float rounding = max(size.x, max(size.y, size.z)) / 262144.0;  // 2^-18
  return position_world + geometric_normal * (rounding + 0.1 * pixel_size_m + lift_m);
}

vec3 lit_side(SurfacePoint point, LightSample light) {
  const vec3 normal = point.plane_normal_world;
  return dot(normal, light.to_light) < 0 ? -normal : normal;
}

struct ShadowRay {
  vec3 origin;
  LightSample light;  // as it is seen from there
};

// Off the surface on the side that the light is on, so that thin sheets lit from behind are not taken for their own
// shadow. Maps are asked about the same ray that is traced where they cannot tell.
ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, LightPlace place, LightSample light) {
  const vec3 side = lit_side(point, light);
  ShadowRay ray;
  ray.origin = offset_from_surface(point.position_world, side, globals.value.eye_world, point.pixel_size_m, point.lift_m);
  ray.light = sample_light(place, ray.origin);
  return ray;
}

ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, uint light_index, LightSample light) {
  return shadow_ray(globals, point, LightPlaceRef(globals.value.light_places).at[light_index], light);
}

#endif
