// Raster of a prepared triangle's part in one tile, pixel by pixel, with 64-bit edge functions.
#ifndef FIRE3DV_TILE_RASTER_GLSL
#define FIRE3DV_TILE_RASTER_GLSL
#ifdef FIRE3DV_LIGHTS
#include "visibility/light_raster.glsl"
#else
#include "visibility/camera_raster.glsl"
#endif

const int kTileThreads = 256;  // threads of a tile

struct TileTriangle {
  ScreenVertex a, b, c;
  ivec3 bias;
  int64_t area;
  uint id;
};

TileTriangle tile_triangle(PreparedTriangle p) {
  TileTriangle t;
  t.a = ScreenVertex(p.a, p.za);
  t.b = ScreenVertex(p.b, p.zb);
  t.c = ScreenVertex(p.c, p.zc);
  t.bias = ivec3(edge_bias(p.b, p.c), edge_bias(p.c, p.a), edge_bias(p.a, p.b));
  const ivec2 ab = p.b - p.a, ac = p.c - p.a;
  t.area = int64_t(ab.x) * ac.y - int64_t(ab.y) * ac.x;
  t.id = p.id;
  return t;
}

bool is_masked(GlobalsRef globals, uint id) {
  return kMasks && (PartRef(globals.value.parts).at[part_of_id(globals, id)].flags & FIRE3DV_PART_MASK) != 0;
}

void draw_tile_pixel(GlobalsRef globals, RasterSet set, RasterView view, TileTriangle t, ivec2 pixel) {
  const ivec2 size = ivec2(view.width, view.height);
  if (pixel.x >= size.x || pixel.y >= size.y) return;
  const ScreenVertex a = t.a, b = t.b, c = t.c;
  const ivec3 bias = t.bias;
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  precise const float inverse_area = 1 / float(t.area);
#ifdef FIRE3DV_LIGHTS
  const ivec2 texel = pixel;
  const MapTarget target = map_target(set, view);
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  const bool has_area = t.area > 0;
  const bool is_broad = is_broad_triangle(float(t.area), ab, bc, ca);
  const int reach = reach_of(view);
#endif
  FIRE3DV_COVER_TEXEL(int64_t, i64vec2)
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  if (!touches) return;
  put_nearest(target, uint(texel.y) * view.width + uint(texel.x), true, nearest_possible(view, outer));
#endif
  if (!covers_center) return;
#else
  FIRE3DV_COVER_PIXEL(int64_t, i64vec2)
  if (covered == 0) return;
#endif
  if (is_masked(globals, t.id)) {
    const VisibleTriangle triangle = seen_from(visible_triangle(globals, t.id), view);
#ifdef FIRE3DV_LIGHTS
    if (!is_solid_at(globals, triangle, vec2(texel) + 0.5, vec2(size))) return;
#else
    if (!is_solid_at(globals, triangle, tested_position(pixel, covered), vec2(size))) return;
#endif
  }
#ifdef FIRE3DV_LIGHTS
  put_nearest(target, uint(texel.y) * view.width + uint(texel.x), false, z);
#else
  const uint first = view.first_texel + uint(pixel.y * size.x + pixel.x) * FIRE3DV_SAMPLES;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    if ((covered & (1u << s)) != 0) put(set, first + s, depth[s], t.id, true);
  }
#endif
}

#ifndef FIRE3DV_LIGHTS
// Draws all rows of a solid triangle with kTileThreads lanes. A lane processes one sample column downwards,
// so that simultaneous writes are adjacent in memory.
void draw_tile_rows(RasterSet set, RasterView view, TileTriangle t, ivec2 origin, uint lane) {
  const uint lanes_across = FIRE3DV_SAMPLES << kTileShift, rows_at_once = kTileThreads / lanes_across;
  const ivec2 size = ivec2(view.width, view.height);
  const uint s = lane % FIRE3DV_SAMPLES;
  const ScreenVertex a = t.a, b = t.b, c = t.c;
  ivec2 low, high;
  covered_pixels(min(a.xy, min(b.xy, c.xy)), max(a.xy, max(b.xy, c.xy)), 0, size, low, high);
  const ivec2 first = ivec2(origin.x + int(lane % lanes_across) / FIRE3DV_SAMPLES, max(origin.y, low.y) + int(lane / lanes_across));
  const int last_y = min(origin.y + (1 << kTileShift) - 1, high.y);
  if (first.x < low.x || first.x > high.x) return;
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  precise const float inverse_area = 1 / float(t.area);
  const ivec2 position = first * kSubpixels + kSamplePosition[s];
  const ivec2 from_a = position - a.xy, from_b = position - b.xy, from_c = position - c.xy;
  // Less the bias: a sample is covered where all are positive.
  int64_t wa = int64_t(bc.x) * from_b.y - int64_t(bc.y) * from_b.x - t.bias.x;
  int64_t wb = int64_t(ca.x) * from_c.y - int64_t(ca.y) * from_c.x - t.bias.y;
  int64_t wc = int64_t(ab.x) * from_a.y - int64_t(ab.y) * from_a.x - t.bias.z;
  const i64vec3 down = i64vec3(bc.x, ca.x, ab.x) * int64_t(kSubpixels * int(rows_at_once));
  uint index = view.first_texel + uint(first.y * size.x + first.x) * FIRE3DV_SAMPLES + s;
  for (int y = first.y; y <= last_y; y += int(rows_at_once)) {
    if ((wa | wb | wc) >= 0) {
      // Matches FIRE3DV_COVER_PIXEL bit for bit.
      precise const float z =
          (float(wa + t.bias.x) * a.z + float(wb + t.bias.y) * b.z + float(wc + t.bias.z) * c.z) * inverse_area;
      put(set, index, z, t.id, true);
    }
    wa += down.x;
    wb += down.y;
    wc += down.z;
    index += rows_at_once * uint(size.x) * FIRE3DV_SAMPLES;
  }
}
#endif

#endif
