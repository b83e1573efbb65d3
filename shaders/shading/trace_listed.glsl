// Tracing of one listed shadow ray. The including shader defines is_shadowed().
#ifndef FIRE3DV_TRACE_LISTED_GLSL
#define FIRE3DV_TRACE_LISTED_GLSL
#include "shading/lights.glsl"

bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m);

// Number of rays to trace; 0 on overflow, when the list OVERFLOW covers all pixels, since the set of rays that
// found room varies between runs.
uint listed_ray_count(ShadowPush push) {
  const uint count = RayListRef(push.lists).at[FIRE3DV_LIST_RAYS].width;
  return count > push.ray_list_capacity ? 0 : count;
}

void trace_listed(GlobalsRef globals, ListedRay ray) {
  const LightSample light = sample_light(globals, ray.light, ray.origin_world);
  if (is_shadowed(globals, ray.origin_world, light.to_light, light.distance_m)) return;
  // Other rays of the pixel may run concurrently.
  atomicOr(UintsRef(globals.value.shadow_mask).at[ray.pixel], ray.lit);
}

#endif
