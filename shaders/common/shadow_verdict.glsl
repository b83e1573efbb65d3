// What can be told of a light's shadow on a surface without a ray.
#ifndef FIRE3DV_SHADOW_VERDICT_GLSL
#define FIRE3DV_SHADOW_VERDICT_GLSL
#include "common/culling.glsl"
#include "common/shadow_maps.glsl"
#include "common/shadow_ray.glsl"
#include "common/visible_triangle.glsl"

// Of a body that is seen from outside: a ray from a side that is turned away from the light starts inside of it.
bool is_body(GlobalsRef globals, uint part) { return casts_by_far_sides(globals, part); }

bool is_turned_away(SurfacePoint point, LightSample light) {
  return dot(point.plane_normal_world, light.to_light) < -0.02 - light.sine;
}

// body: see is_body; light: as it is seen from the point. origin: of the ray that a hard light's map cannot replace.
uint shadow_verdict(GlobalsRef globals, LightShadow shadow, uint light_index, LightSample light, SurfacePoint point,
                    uint part, bool body, out vec3 origin) {
  origin = vec3(0);
  if (body && is_turned_away(point, light)) return kShadowed;
  if (shadow.rays != 1) return kUnknown;  // a map knows of one ray
  const ShadowRay ray = shadow_ray(globals, point, light_index, light);
  origin = ray.origin;
  return map_verdict(globals, view_of(globals, shadow, ray.light), part, ray.origin, point.plane_normal_world, ray.light);
}

#endif
