// Clipping of a triangle at the near plane and at the guard band (Sutherland and Hodgman 1974). A new vertex
// is always computed from the inner vertex towards the outer one. Triangles that share an edge therefore get
// bit-identical vertices.
#ifndef FIRE3DV_CLIP_POLYGON_GLSL
#define FIRE3DV_CLIP_POLYGON_GLSL
#include "visibility/raster_rules.glsl"

const int kMaxClipVertices = 8;

const float kNearPlane = -1;

// Signed distance inside a plane, with exactly the comparison of can_be_projected(). guard: kNearPlane, or
// the multiple of w at which the side plane lies.
float distance_inside_of(float guard, vec2 side, vec4 clip) {
  if (guard == kNearPlane) return clip.w - clip.z;
  precise const float limit = guard * clip.w;
  precise const float result = limit - (side.x * clip.x + side.y * clip.y);
  return result;
}

void cut(float guard, vec2 side, inout vec4 corners[kMaxClipVertices], inout int count) {
  vec4 clipped[kMaxClipVertices];
  int clipped_count = 0;
  for (int i = 0; i < count; ++i) {
    const vec4 here = corners[i], next = corners[i + 1 < count ? i + 1 : 0];
    const float distance_here = distance_inside_of(guard, side, here), distance_next = distance_inside_of(guard, side, next);
    if (distance_here >= 0 && clipped_count < kMaxClipVertices) clipped[clipped_count++] = here;
    if ((distance_here >= 0) != (distance_next >= 0) && clipped_count < kMaxClipVertices) {
      const bool here_inside = distance_here >= 0;
      const vec4 inside = here_inside ? here : next, outside = here_inside ? next : here;
      const float distance_inside = here_inside ? distance_here : distance_next;
      const float distance_outside = here_inside ? distance_next : distance_here;
      precise const vec4 corner = inside + (outside - inside) * (distance_inside / (distance_inside - distance_outside));
      clipped[clipped_count++] = corner;
    }
  }
  corners = clipped;
  count = clipped_count;
}

void cut_to_view(inout vec4 corners[kMaxClipVertices], inout int count, vec2 size) {
  // Rounding may put a new vertex slightly outside; the guard band has room for that.
  const vec2 guard = kGuardPixels / size;
  const float guards[5] = float[5](kNearPlane, guard.x, guard.x, guard.y, guard.y);
  const vec2 sides[5] = vec2[5](vec2(0), vec2(1, 0), vec2(-1, 0), vec2(0, 1), vec2(0, -1));
  for (int i = 0; i < 5; ++i) cut(guards[i], sides[i], corners, count);
}

#endif
