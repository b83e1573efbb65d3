// Variant of visibility/tiles.comp for devices that are a CPU (see lanes.glsl): a one-vector workgroup draws all large
// triangles of its tile in sequence. It is the only writer of the tile, so it needs no atomics and skips
// hidden blocks. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "visibility/interleaved_groups.glsl"
#include "visibility/large_triangles.glsl"
#include "visibility/tile_lanes.glsl"

layout(local_size_x = 8) in;
layout(push_constant, scalar) uniform Push { RasterPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

GlobalsRef globals;
uint64_t visibility;
uint generation;
RasterView view;
uint first_sample;  // of the view
ivec2 image_size;
ivec2 tile_pixel;  // first pixel of the tile
int own_pixel;     // pixel in the vector; each lane has one of its samples
uint own_sample;
// Farthest visible depth of the lane's block, and of the block eight further.
float farthest[2];

struct LaneTriangle {
  LaneEdge a, b, c;
  ivec3 bias;
  vec3 z;
  float inverse_area;
  uint id;
  bool masked;
};

LaneTriangle lane_triangle(TileTriangle whole) {
  const ivec2 position = tile_pixel * kSubpixels, own = ivec2(own_pixel * kSubpixels, 0) + kSamplePosition[own_sample];
  LaneTriangle t;
  t.bias = whole.bias;
  t.a = lane_edge(whole.b.xy, whole.c.xy, t.bias.x, position, own);
  t.b = lane_edge(whole.c.xy, whole.a.xy, t.bias.y, position, own);
  t.c = lane_edge(whole.a.xy, whole.b.xy, t.bias.z, position, own);
  t.z = vec3(whole.a.z, whole.b.z, whole.c.z);
  precise const float inverse_area = 1 / float(whole.area);
  t.inverse_area = inverse_area;
  t.id = whole.id;
  t.masked = is_masked(globals, whole.id);
  return t;
}

// Bit masks over eight blocks of half a tile.
struct Blocks {
  uint reached;  // the bounds of the block may show the triangle
  uint covered;  // the triangle covers all samples
};

Blocks blocks_of_half(LaneTriangle t, const int half_tile) {
  const BlockEdges edges = block_edges(t.a, t.b, t.c, half_tile);
  // Nearest depth of the plane in the block, limited by the triangle's vertices.
  const float corner = max(t.z.x, max(t.z.y, t.z.z));
  const float rounding =
      4e-6 * corner * (1 + dot(abs(edges.first) + 1e6 * edges.slack, vec3(1)) * t.inverse_area);
  const float across = max(dot(edges.right, t.z) * kBlockReach, 0), along = max(dot(edges.down, t.z) * kBlockReach, 0);
  const float plane = (dot(edges.first, t.z) + across + along) * t.inverse_area + rounding;
  const bool hidden = min(plane, corner * 1.000001) < farthest[half_tile];
  const ivec2 pixel = tile_pixel + block_position(int(gl_SubgroupInvocationID) + 8 * half_tile) * kBlock;
  Blocks blocks;
  blocks.reached = subgroupBallot(reaches_block(edges) && !hidden && all(lessThan(pixel, image_size))).x;
  blocks.covered = subgroupBallot(all(greaterThan(least_of(edges), edges.slack))).x;
  return blocks;
}

// All lanes must call it. least: minimum of the drawn depths.
void put_lane(LaneTriangle t, bool covered, ivec2 pixel, float depth, inout float least) {
#if FIRE3DV_SAMPLES == 4
  const uint samples = t.masked ? (subgroupBallot(covered).x >> (4 * own_pixel)) & 15 : 0;
#else
  const uint samples = 1;
#endif
  if (!covered || pixel.x >= image_size.x) return;
  least = min(least, depth);
  if (depth < 0) return;  // beyond the far plane
  VisibilityRef seen = VisibilityRef(visibility);
  const uint index = first_sample + uint(pixel.y * image_size.x + pixel.x) * FIRE3DV_SAMPLES + own_sample;
  const uint64_t value = seen_value(depth, t.id, generation);
  if (seen.at[index] >= value) return;
  if (t.masked) {
    const VisibleTriangle triangle = seen_from(visible_triangle(globals, t.id), view);
    if (!is_solid_at(globals, triangle, tested_position(pixel, samples), vec2(image_size))) return;
  }
  seen.at[index] = value;
}

// Returns the farthest depth of the block's covered samples.
float draw_block(LaneTriangle t, const bool wide, ivec2 block) {
  const ivec2 first = tile_pixel + block * kBlock + ivec2(own_pixel, 0);
  const int rows = min(kBlock, image_size.y - first.y);
  Parts row_a = at_block(t.a, block), row_b = at_block(t.b, block), row_c = at_block(t.c, block);
  float least = 1e30;
  for (int y = 0; y < rows; ++y) {
    Parts a = row_a, b = row_b, c = row_c;
    for (int i = 0; i < FIRE3DV_SAMPLES; ++i) {
      const Parts wa = carried(a), wb = carried(b), wc = carried(c);
      const bool covered = (wa.high | wb.high | wc.high) >= 0;
      precise const float depth =
          (float_of(wa.high, wa.low + t.bias.x, wide) * t.z.x + float_of(wb.high, wb.low + t.bias.y, wide) * t.z.y +
           float_of(wc.high, wc.low + t.bias.z, wide) * t.z.z) *
          t.inverse_area;
      put_lane(t, covered, first + ivec2(i * kVectorPixels, y), depth, least);
      a = stepped(a, t.a.right, 1);
      b = stepped(b, t.b.right, 1);
      c = stepped(c, t.c.right, 1);
    }
    row_a = stepped(row_a, t.a.down, 1);
    row_b = stepped(row_b, t.b.down, 1);
    row_c = stepped(row_c, t.c.down, 1);
  }
  return least;
}

void draw(LaneTriangle t, const bool wide) {
  const Blocks low = blocks_of_half(t, 0), high = blocks_of_half(t, 1);
  uint reached = low.reached | high.reached << 8;
  const uint covered = t.masked ? 0 : low.covered | high.covered << 8;
  while (reached != 0) {
    const int number = findLSB(reached);
    reached &= reached - 1;
    const float least = draw_block(t, wide, block_position(number));
    if ((covered & (1u << number)) == 0) continue;
    const float hides = min_of_lanes(least);
    if (int(gl_SubgroupInvocationID) == (number & 7)) {
      if (number < 8) farthest[0] = max(farthest[0], hides);
      else farthest[1] = max(farthest[1], hides);
    }
  }
}

// 64-bit version for triangles whose edge functions do not fit Parts.
void draw_vast(TileTriangle whole, LaneTriangle t) {
  const ScreenVertex a = whole.a, b = whole.b, c = whole.c;
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  float least = 0;
  for (int i = 0; i < kTileSide * kTileSide / kVectorPixels; ++i) {
    const int across = kTileSide / kVectorPixels;
    const ivec2 pixel = tile_pixel + ivec2((i % across) * kVectorPixels + own_pixel, i / across);
    if (pixel.y >= image_size.y) break;  // all lanes
    const ivec2 position = pixel * kSubpixels + kSamplePosition[own_sample];
    const i64vec2 from_a = i64vec2(position - a.xy), from_b = i64vec2(position - b.xy), from_c = i64vec2(position - c.xy);
    const int64_t wa = int64_t(bc.x) * from_b.y - int64_t(bc.y) * from_b.x;
    const int64_t wb = int64_t(ca.x) * from_c.y - int64_t(ca.y) * from_c.x;
    const int64_t wc = int64_t(ab.x) * from_a.y - int64_t(ab.y) * from_a.x;
    precise const float depth = (float(wa) * a.z + float(wb) * b.z + float(wc) * c.z) * t.inverse_area;
    put_lane(t, wa >= t.bias.x && wb >= t.bias.y && wc >= t.bias.z, pixel, depth, least);
  }
}

void main() {
  globals = globals_at(push.globals);
  const RasterSet set = RasterSetRef(push.set).value;
  const uvec3 group = layers_group();
  if (kSeveralWorlds) globals = globals_of_view(set, group.z);
  view = view_for_all(set.views, group.z);
  first_sample = view.first_texel;
  visibility = set.target;
  generation = set.generation;
  image_size = ivec2(view.width, view.height);
  const ivec2 tile = ivec2(group.xy);
  tile_pixel = tile << kTileShift;
  own_pixel = int(gl_SubgroupInvocationID) / FIRE3DV_SAMPLES;
  own_sample = gl_SubgroupInvocationID % FIRE3DV_SAMPLES;
  farthest[0] = farthest[1] = 0;
  uint next = UintRef(set.tile_lists).at[list_of_tile(view, tile)];
  while (next != 0) {
    const uint entry = next - 1;
    const TileTriangle whole = tile_triangle(prepared_for_all(set.prepared, TileEntryRef(set.tiles).at[entry].prepared));
    next = is_ended() ? 0 : UintRef(set.tile_next).at[entry];
    const LaneTriangle triangle = lane_triangle(whole);
    if (largest_edge_function(whole) >= int64_t(1) << 54) {
      draw_vast(whole, triangle);
    } else if (whole.area >= int64_t(1) << 48) {
      draw(triangle, true);
    } else {
      draw(triangle, false);
    }
  }
}
