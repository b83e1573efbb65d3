// Queues of triangles too large for one thread. A triangle with few tiles is queued as tiles; one with many
// tiles, or one that needs clipping, is queued for expansion by a workgroup.
#ifndef FIRE3DV_LARGE_TRIANGLES_GLSL
#define FIRE3DV_LARGE_TRIANGLES_GLSL
#include "visibility/raster_rules.glsl"

const int kMaxTilesByOne = 16;

void emit_huge(RasterSet set, HugeTriangle triangle) {
  LargeWorkRef large = LargeWorkRef(set.large);
  const uint slot = atomicAdd(large.value.expand.count, 1);
  if (slot >= set.huge_capacity) {
    atomicAdd(large.value.lost, 1);  // the host makes room for the next frame
    return;
  }
  HugeTriangleRef(set.huge).at[slot] = triangle;
  atomicMax(large.value.expand.groups_x, min(slot + 1, 65535u));
  atomicMax(large.value.expand.groups_y, slot / 65535 + 1);
  large.value.expand.groups_z = 1;
}

// Orders the vertices for a positive area; returns false when the triangle is invisible.
bool prepare(HugeTriangle triangle, ScreenVertex a, ScreenVertex b, ScreenVertex c, bool mirrored, bool double_sided,
             out PreparedTriangle prepared) {
  const ivec2 ab = b.xy - a.xy, ac = c.xy - a.xy;
  const int64_t area = int64_t(ab.x) * ac.y - int64_t(ab.y) * ac.x;
#ifndef FIRE3DV_KEEPS_LINES
  if (area == 0 || (!double_sided && (area > 0) != mirrored)) return false;
#endif
  const bool swap_corners = area < 0;
  prepared.a = a.xy;
  prepared.za = a.z;
  prepared.b = swap_corners ? c.xy : b.xy;
  prepared.zb = swap_corners ? c.z : b.z;
  prepared.c = swap_corners ? b.xy : c.xy;
  prepared.zc = swap_corners ? b.z : c.z;
  prepared.id = triangle.id;
  prepared.view = triangle.view;
  return true;
}

// Conservative test of a triangle against a box of pixels; exact except at the box's corners.
bool reaches_box(PreparedTriangle t, ivec2 low_pixel, ivec2 high_pixel) {
#ifdef FIRE3DV_KEEPS_LINES
  const int margin = kSubpixels;  // more than any map's reach
#else
  const int margin = 4;
#endif
  const ivec2 low = low_pixel * kSubpixels - margin, high = (high_pixel + 1) * kSubpixels + margin;
  const ivec2 corner[3] = ivec2[3](t.a, t.b, t.c);
  for (int i = 0; i < 3; ++i) {
    const ivec2 from = corner[i], d = corner[(i + 1) % 3] - from;
    // The corner of the box farthest inside the edge.
    const ivec2 best = ivec2(d.y > 0 ? low.x : high.x, d.x > 0 ? high.y : low.y);
    if (int64_t(d.x) * (best.y - from.y) - int64_t(d.y) * (best.x - from.x) < 0) return false;
  }
  return true;
}

// Reserves tile entries; indices from the capacity on do not exist.
uint slots_for_tiles(RasterSet set, uint count) {
  LargeWorkRef large = LargeWorkRef(set.large);
  const uint first = atomicAdd(large.value.tiles.count, count);
  const uint all = min(first + count, set.tile_capacity);
  if (first >= all) return first;
  atomicMax(large.value.tiles.groups_x, min(all, 65535u));
  atomicMax(large.value.tiles.groups_y, (all - 1) / 65535 + 1);
  large.value.tiles.groups_z = 1;
  return first;
}

// Returns false when the list is full.
bool emit_tile(RasterSet set, uint slot, uint prepared, ivec2 tile, RasterView view) {
  if (slot >= set.tile_capacity) return false;
  TileEntryRef(set.tiles).at[slot] = TileEntry(prepared, uint(tile.x) | (uint(tile.y) << 16));
  if (set.tile_lists != 0) {
    UintsRef(set.tile_next).at[slot] = atomicExchange(UintsRef(set.tile_lists).at[list_of_tile(view, tile)], slot + 1);
  }
  return true;
}

void emit_large(RasterSet set, HugeTriangle triangle, ScreenVertex a, ScreenVertex b, ScreenVertex c, bool mirrored, bool double_sided,
                ivec2 low, ivec2 high, RasterView view) {
  const ivec2 first = low >> kTileShift, tiles = (high >> kTileShift) - first + 1;
  PreparedTriangle prepared;
  if (!prepare(triangle, a, b, c, mirrored, double_sided, prepared)) return;
  LargeWorkRef large = LargeWorkRef(set.large);
  const uint count = uint(tiles.x * tiles.y);
  if (count > kMaxTilesByOne || large.value.tiles.count + 65536 > set.tile_capacity ||
      large.value.prepared_count + 65536 > set.prepared_capacity) {
    emit_huge(set, triangle);  // also when room is scarce: only this queue handles overflow
    return;
  }
  const uint slot = atomicAdd(large.value.prepared_count, 1);
  if (slot >= set.prepared_capacity) {
    emit_huge(set, triangle);
    return;
  }
  PreparedTriangleRef(set.prepared).at[slot] = prepared;
  uint reached = 0;  // its tiles, as bits
  for (uint i = 0; i < count; ++i) {
    const ivec2 tile = first + ivec2(i % uint(tiles.x), i / uint(tiles.x));
    if (reaches_box(prepared, tile << kTileShift, ((tile + 1) << kTileShift) - 1)) reached |= 1u << i;
  }
  uint entry = slots_for_tiles(set, bitCount(reached));
  for (; reached != 0; reached &= reached - 1, ++entry) {
    const uint i = findLSB(reached);
    if (!emit_tile(set, entry, slot, first + ivec2(i % uint(tiles.x), i / uint(tiles.x)), view)) {
      emit_huge(set, triangle);  // redraws the whole triangle; the result is the same
      return;
    }
  }
}

#endif
