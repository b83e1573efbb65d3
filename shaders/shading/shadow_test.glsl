// Shadow test of a light without a ray: facing and shadow maps.
#ifndef FIRE3DV_SHADOW_TEST_GLSL
#define FIRE3DV_SHADOW_TEST_GLSL
#include "visibility/culling.glsl"
#include "shading/shadow_maps.glsl"
#include "shading/shadow_ray.glsl"
#include "common/visible_triangle.glsl"

// True for closed meshes seen from outside: a ray from a surface turned away from the light starts inside of
// the mesh.
bool is_closed_mesh(GlobalsRef globals, uint part) { return casts_by_back_faces(globals, part); }

bool is_turned_away(SurfacePoint point, LightSample light) {
  return point.smooth_height_m == 0 && dot(point.plane_normal_world, light.to_light) < -0.02 - light.sine;
}

// A closed mesh's map has its back faces only. A ray from below the triangle's horizon starts at or below the
// mesh's surface and may leave it through a front face, so that such a map cannot tell light for certain.
uint without_front_faces(uint shadow_state, bool body, SurfacePoint point, LightSample light) {
  const bool starts_inside = body && dot(point.plane_normal_world, light.to_light) < 0;
  return shadow_state == kLit && starts_inside ? kUnresolved : shadow_state;
}

// body: see is_closed_mesh. light: sampled from the point. origin: of the hard light's ray, which a caller traces
// for an unresolved result.
uint shadow_test(GlobalsRef globals, LightShadow shadow, uint light_index, LightSample light, SurfacePoint point,
                    uint part, bool body, out vec3 origin) {
  origin = vec3(0);
  if (body && is_turned_away(point, light)) return kShadowed;
  if (shadow.rays != 1) return kUnresolved;  // a map represents one ray
  const ShadowRay ray = shadow_ray(globals, point, light_index, light);
  origin = ray.origin;
  const uint shadow_state =
      shadow_map_test(globals, view_of(globals, shadow, ray.light), part, ray.origin, point.plane_normal_world, ray.light);
  return without_front_faces(shadow_state, body, point, light);
}

#endif
