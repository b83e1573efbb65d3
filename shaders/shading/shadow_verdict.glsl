// Shadow test of a light without a ray: facing and shadow maps.
#ifndef FIRE3DV_SHADOW_VERDICT_GLSL
#define FIRE3DV_SHADOW_VERDICT_GLSL
#include "visibility/culling.glsl"
#include "shading/shadow_maps.glsl"
#include "shading/shadow_ray.glsl"
#include "common/visible_triangle.glsl"

// True for closed meshes seen from outside: a ray from a surface turned away from the light starts inside of
// the mesh.
bool is_body(GlobalsRef globals, uint part) { return casts_by_far_sides(globals, part); }

bool is_turned_away(SurfacePoint point, LightSample light) {
  return dot(point.plane_normal_world, light.to_light) < -0.02 - light.sine;
}

// body: see is_body. light: sampled from the point. origin: of the hard light's ray, which a caller traces
// for an unknown result.
uint shadow_verdict(GlobalsRef globals, LightShadow shadow, uint light_index, LightSample light, SurfacePoint point,
                    uint part, bool body, out vec3 origin) {
  origin = vec3(0);
  if (body && is_turned_away(point, light)) return kShadowed;
  if (shadow.rays != 1) return kUnknown;  // a map represents one ray
  const ShadowRay ray = shadow_ray(globals, point, light_index, light);
  origin = ray.origin;
  return map_verdict(globals, view_of(globals, shadow, ray.light), part, ray.origin, point.plane_normal_world, ray.light);
}

#endif
