// Raster of a triangle by one thread, with 32-bit edge functions. Variants as in visibility/raster.comp.
#ifndef FIRE3DV_SMALL_TRIANGLES_GLSL
#define FIRE3DV_SMALL_TRIANGLES_GLSL
#ifdef FIRE3DV_LIGHTS
#include "visibility/light_raster.glsl"
#else
#include "visibility/camera_raster.glsl"
#endif

const int kMaxPixels = 256;            // of a box that one thread rasterises
const int kMaxExtent = 64 * kSubpixels;  // edge functions fit 32 bits

// Incremental 32-bit edge functions over a box of pixels, row by row, from left to right.
struct Walk {
  ivec3 at;       // at the corner of this pixel
  ivec3 right;    // step to the next pixel
  ivec3 next_row;  // step from the last pixel of a row to the first of the next
  int x, first_x, last_x;
  uint index;     // pixel index, in a target with rows of `width`
  uint row_jump;
};

Walk walk_from(ScreenVertex a, ScreenVertex b, ScreenVertex c, ivec2 low, ivec2 high, uint width) {
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const ivec3 along_x = -ivec3(bc.y, ca.y, ab.y), along_y = ivec3(bc.x, ca.x, ab.x);
  const ivec2 corner = low * kSubpixels;
  const ivec2 from_a = corner - a.xy, from_b = corner - b.xy, from_c = corner - c.xy;
  Walk walk;
  walk.at = along_y * ivec3(from_b.y, from_c.y, from_a.y) + along_x * ivec3(from_b.x, from_c.x, from_a.x);
  walk.right = along_x * kSubpixels;
  walk.next_row = along_y * kSubpixels - walk.right * (high.x - low.x);
  walk.x = walk.first_x = low.x;
  walk.last_x = high.x;
  walk.index = uint(low.y) * width + uint(low.x);
  walk.row_jump = width - uint(high.x - low.x);
  return walk;
}

// A single loop over all pixels: with nested loops, every row would take as long as the widest triangle of
// the subgroup.
void step_on(inout Walk walk) {
  const bool at_end = walk.x == walk.last_x;
  walk.at += at_end ? walk.next_row : walk.right;
  walk.index += at_end ? walk.row_jump : 1;
  walk.x = at_end ? walk.first_x : walk.x + 1;
}

bool all_positive(ivec3 v) { return (v.x | v.y | v.z) >= 0; }

// Depths match FIRE3DV_COVER_PIXEL and FIRE3DV_COVER_TEXEL bit for bit.
float depth_of(ivec3 weights, ScreenVertex a, ScreenVertex b, ScreenVertex c, float inverse_area) {
  precise const float z = (float(weights.x) * a.z + float(weights.y) * b.z + float(weights.z) * c.z) * inverse_area;
  return z;
}

#ifdef FIRE3DV_LIGHTS
void draw_small(GlobalsRef globals, RasterSet set, RasterView view, ScreenVertex a, ScreenVertex b, ScreenVertex c, int area, uint id,
                ivec2 low, ivec2 high) {
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const ivec3 bias = ivec3(edge_bias(b.xy, c.xy), edge_bias(c.xy, a.xy), edge_bias(a.xy, b.xy));
  precise const float inverse_area = 1 / float(area);
  const MapTarget target = map_target(set, view);
  Walk walk = walk_from(a, b, c, low, high, view.width);
  walk.at += (ivec3(bc.x, ca.x, ab.x) - ivec3(bc.y, ca.y, ab.y)) * kHalfPixel;  // to texel centres
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  const int reach = reach_of(view);
  const ivec3 touched_from = ivec3(abs(bc.x) + abs(bc.y), abs(ca.x) + abs(ca.y), abs(ab.x) + abs(ab.y)) * reach;
  const OuterDepth outer = outer_depth_of(a, b, c, inverse_area, reach, is_broad_triangle(float(area), ab, bc, ca));
#endif
#ifdef FIRE3DV_ALPHA_MASK
  const VisibleTriangle triangle = seen_from(visible_triangle(globals, id), view);
#endif
  for (int left = (high.x - low.x + 1) * (high.y - low.y + 1); left > 0; --left, step_on(walk)) {
#if defined(FIRE3DV_CENTER_MAPS_ONLY) && defined(FIRE3DV_CPU)
    // On a CPU a write costs the same for one lane as for all, and far more than a step. So each lane
    // advances to its next covered texel before all write together. Outer maps cover nearly all texels of a
    // box.
    while (left > 1 && !all_positive(walk.at - bias)) {
      step_on(walk);
      --left;
    }
#endif
    const bool covers_center = area > 0 && all_positive(walk.at - bias);
#ifdef FIRE3DV_CENTER_MAPS_ONLY
    if (!covers_center) continue;
#else
    if (!all_positive(walk.at + touched_from)) continue;
#endif
    const float z = depth_of(walk.at, a, b, c, inverse_area);
#ifndef FIRE3DV_CENTER_MAPS_ONLY
    put_nearest(target, walk.index, true, nearest_possible(view, outer_depth(outer, z)));
    if (!covers_center) continue;
#endif
#ifdef FIRE3DV_ALPHA_MASK
    const ivec2 texel = ivec2(walk.index % view.width, walk.index / view.width);
    if (!is_solid_at(globals, triangle, vec2(texel) + 0.5, vec2(view.width))) continue;
#endif
    put_nearest(target, walk.index, false, z);
  }
}
#else
void draw_small(GlobalsRef globals, RasterSet set, RasterView view, ScreenVertex a, ScreenVertex b, ScreenVertex c, int area, uint id,
                ivec2 low, ivec2 high) {
  const ivec3 bias = ivec3(edge_bias(b.xy, c.xy), edge_bias(c.xy, a.xy), edge_bias(a.xy, b.xy));
  precise const float inverse_area = 1 / float(area);
#ifdef FIRE3DV_ALPHA_MASK
  const VisibleTriangle triangle = seen_from(visible_triangle(globals, id), view);
#endif
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const ivec3 along_x = -ivec3(bc.y, ca.y, ab.y), along_y = ivec3(bc.x, ca.x, ab.x);
  // From a pixel's corner to a sample, less the bias: covered where all are positive.
  ivec3 to_sample[FIRE3DV_SAMPLES];
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) to_sample[s] = along_x * kSamplePosition[s].x + along_y * kSamplePosition[s].y - bias;
  Walk walk = walk_from(a, b, c, low, high, view.width);
  const int count = (high.x - low.x + 1) * (high.y - low.y + 1);
  for (int i = 0; i < count; ++i, step_on(walk)) {
    uint covered = 0;
    for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
      if (all_positive(walk.at + to_sample[s])) covered |= 1u << s;
    }
    if (covered == 0) continue;
#ifdef FIRE3DV_ALPHA_MASK
    const ivec2 pixel = ivec2(walk.index % view.width, walk.index / view.width);
    if (!is_solid_at(globals, triangle, tested_position(pixel, covered), vec2(view.width, view.height))) continue;
#endif
    const uint first = view.first_texel + walk.index * FIRE3DV_SAMPLES;
#if defined(FIRE3DV_NARROW) && FIRE3DV_SAMPLES == 4
    // Most tiny triangles cover one sample.
    for (uint left = covered; left != 0; left &= left - 1) {
      const int s = findLSB(left);
      // kSamplePosition[s] without a memory access
      const ivec2 position = ivec2(s == 0 ? 96 : s == 1 ? 224 : s == 2 ? 32 : 160, 32 + 64 * s);
      put(set, first + s, depth_of(walk.at + along_x * position.x + along_y * position.y, a, b, c, inverse_area), id, false);
    }
#else
    for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
      if ((covered & (1u << s)) == 0) continue;
      put(set, first + s, depth_of(walk.at + to_sample[s] + bias, a, b, c, inverse_area), id, false);
    }
#endif
  }
}
#endif

#endif
