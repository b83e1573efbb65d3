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

vec3 lit_side(SurfacePoint point, LightSample light) {
  const vec3 normal = point.plane_normal_world;
  return dot(normal, light.to_light) < 0 ? -normal : normal;
}

struct ShadowRay {
  vec3 origin;
  LightSample light;  // sampled from the origin
};

// The origin lies on the light's side, so that thin surfaces lit from behind do not shadow themselves. Shadow
// maps test the same ray that is traced for unresolved pixels.
ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, LightPose pose, LightSample light) {
  const vec3 side = lit_side(point, light);
  ShadowRay ray;
  ray.origin = offset_from_surface(point.position_world, side, globals.value.eye_world, point.pixel_size_m, point.lift_m);
  ray.light = sample_light(pose, ray.origin);
  return ray;
}

ShadowRay shadow_ray(GlobalsRef globals, SurfacePoint point, uint light_index, LightSample light) {
  return shadow_ray(globals, point, LightPoseRef(globals.value.light_poses).at[light_index], light);
}

#endif
