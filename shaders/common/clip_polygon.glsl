// Cuts a triangle at the near plane and at the guard band around the image (Sutherland and Hodgman 1974). A new corner
// is always made from the corner inside towards the one outside, so that two triangles that share the edge get the same
// one, to the bit.
#ifndef FIRE3DV_CLIP_POLYGON_GLSL
#define FIRE3DV_CLIP_POLYGON_GLSL
#include "common/raster_rules.glsl"

const int kMostCorners = 8;

// Inside where dot(plane, clip) >= 0.
void cut(vec4 plane, inout vec4 corners[kMostCorners], inout int count) {
  vec4 kept[kMostCorners];
  int kept_count = 0;
  for (int i = 0; i < count; ++i) {
    const vec4 here = corners[i], next = corners[i + 1 < count ? i + 1 : 0];
    const float distance_here = dot(plane, here), distance_next = dot(plane, next);
    if (distance_here >= 0 && kept_count < kMostCorners) kept[kept_count++] = here;
    if ((distance_here >= 0) != (distance_next >= 0) && kept_count < kMostCorners) {
      const bool here_inside = distance_here >= 0;
      const vec4 inside = here_inside ? here : next, outside = here_inside ? next : here;
      const float distance_inside = here_inside ? distance_here : distance_next;
      const float distance_outside = here_inside ? distance_next : distance_here;
      precise const vec4 corner = inside + (outside - inside) * (distance_inside / (distance_inside - distance_outside));
      kept[kept_count++] = corner;
    }
  }
  corners = kept;
  count = kept_count;
}

void cut_to_view(inout vec4 corners[kMostCorners], inout int count, vec2 size) {
  cut(vec4(0, 0, -1, 1), corners, count);  // near: z <= w
  // Half the guard band: the rounding of a new corner must not take it out again.
  const vec2 guard = 0.5 * kGuardPixels / size;
  cut(vec4(1, 0, 0, guard.x), corners, count);
  cut(vec4(-1, 0, 0, guard.x), corners, count);
  cut(vec4(0, 1, 0, guard.y), corners, count);
  cut(vec4(0, -1, 0, guard.y), corners, count);
}

#endif
