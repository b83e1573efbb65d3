// Origins of shadow rays, offset from the surface.
#ifndef FIRE3DV_SHADOW_RAY_GLSL
#define FIRE3DV_SHADOW_RAY_GLSL
#include "shading/lights.glsl"
#include "common/surface_point.glsl"

// Offset that keeps the origin above the surface despite rounding. An interpolated position is off by a few
// units in the last place of its coordinates or eye distance, and near edges by a fraction of a pixel. The
// offset therefore scales with scene and view: about 1e-5 m for a needle at 0.1 m.
// lift_m: additional offset below a pixel, where the visible LOD is coarser than the ray-traced one.
vec3 offset_from_surface(vec3 position_world, vec3 geometric_normal, vec3 eye_world, float pixel_size_m, float lift_m) {
  const vec3 size = max(abs(position_world), abs(position_world - eye_world));
  const float rounding = max(size.x, max(size.y, size.z)) / 262144.0;  // 2^-18
  return position_world + geometric_normal * (rounding + 0.1 * pixel_size_m + lift_m);
}

vec3 start_side(SurfacePoint point, vec3 direction) {
  return starts_behind(point, direction) ? -point.plane_normal_world : point.plane_normal_world;
}

// Point that shadow maps without rays test.
vec3 map_point(SurfacePoint point, LightSample light) {
  return point.position_world + (point.lift_m + start_height(point, light.to_light)) * start_side(point, light.to_light);
}

struct ShadowRay {
  vec3 origin;
  LightSample light;  // sampled from the origin
};

// The origin of light that passes a thin surface lies on the light's side, so that the surface does not shadow
// itself. Shadow maps test the same ray that is traced for unresolved pixels.
ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, LightPose pose, LightSample light) {
  ShadowRay ray;
  ray.origin = offset_from_surface(point.position_world, start_side(point, light.to_light), globals.value.eye_world,
                                   point.pixel_size_m, point.lift_m + start_height(point, light.to_light));
  ray.light = sample_light(pose, ray.origin);
  return ray;
}

ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, uint light_index, LightSample light) {
  return shadow_ray(globals, point, LightPoseRef(globals.value.light_poses).at[light_index], light);
}

#endif
