// Variant of visibility/tiles.comp for shadow maps on devices that are a CPU (see lanes.glsl): a one-vector workgroup
// draws all large triangles of its tile in sequence. It is the only writer of the tile, so it needs no
// atomics. Variant: FIRE3DV_CENTER_MAPS_ONLY.
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
RasterSet set;
RasterView view;
ivec2 tile_pixel;  // first pixel of the tile

struct LaneTriangle {
  TileTriangle whole;
  LaneEdge a, b, c;
  Parts less_a, less_b, less_c;  // offset of an edge from its edge function
  float inverse_area;
  bool has_area, masked;
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  OuterDepth outer;
#endif
};

// Margin by which an edge function may be negative in a texel that counts.
int64_t allowed(ivec2 from, ivec2 to, int bias) {
#ifdef FIRE3DV_CENTER_MAPS_ONLY
  return -bias;
#else
  const ivec2 d = abs(to - from);
  return int64_t(d.x + d.y) * reach_of(view);
#endif
}

LaneTriangle lane_triangle(TileTriangle whole) {
  const ivec2 position = tile_pixel * kSubpixels, own = ivec2(gl_SubgroupInvocationID, 0) * kSubpixels + kHalfPixel;
  const ivec2 a = whole.a.xy, b = whole.b.xy, c = whole.c.xy;
  const int64_t more_a = allowed(b, c, whole.bias.x), more_b = allowed(c, a, whole.bias.y), more_c = allowed(a, b, whole.bias.z);
  LaneTriangle t;
  t.whole = whole;
  t.a = lane_edge(b, c, -more_a, position, own);
  t.b = lane_edge(c, a, -more_b, position, own);
  t.c = lane_edge(a, b, -more_c, position, own);
  t.less_a = parts_of(-more_a);
  t.less_b = parts_of(-more_b);
  t.less_c = parts_of(-more_c);
  precise const float inverse_area = 1 / float(whole.area);
  t.inverse_area = inverse_area;
  t.has_area = whole.area > 0;
  t.masked = is_masked(globals, whole.id);
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  t.outer = outer_depth_of(whole.a, whole.b, whole.c, inverse_area, reach_of(view),
                           is_broad_triangle(float(whole.area), b - a, c - b, a - c));
#endif
  return t;
}

void put_alone(ivec2 texel, const bool outer, float depth) {
  UintsRef maps = UintsRef(set.target);
  const uint index = view.first_texel + (outer ? view.width * view.width : 0) + uint(texel.y) * view.width + texel.x;
  const uint value = encode_depth(depth, set.generation);
  if (maps.at[index] < value) maps.at[index] = value;
}

void put_texel(LaneTriangle t, ivec2 texel, vec3 e, bool covers_center) {
  const float z = (e.x * t.whole.a.z + e.y * t.whole.b.z + e.z * t.whole.c.z) * t.inverse_area;
#ifndef FIRE3DV_CENTER_MAPS_ONLY
  put_alone(texel, true, nearest_possible(view, outer_depth(t.outer, z)));
#endif
  if (!covers_center || (t.masked && !is_solid_at(globals, seen_from(visible_triangle(globals, t.whole.id), view),
                                           vec2(texel) + 0.5, vec2(view.width)))) {
    return;
  }
  put_alone(texel, false, z);
}

void draw_block(LaneTriangle t, ivec2 block) {
  const ivec2 first = tile_pixel + block * kBlock + ivec2(gl_SubgroupInvocationID, 0);
  Parts a = at_block(t.a, block), b = at_block(t.b, block), c = at_block(t.c, block);
  for (int y = 0; y < kBlock; ++y) {
    if ((carried(a).high | carried(b).high | carried(c).high) >= 0) {
      const Parts wa = carried(stepped(a, t.less_a, 1)), wb = carried(stepped(b, t.less_b, 1)), wc = carried(stepped(c, t.less_c, 1));
      // A bias of 1 makes only 0 negative.
      const ivec3 low = ivec3(wa.low, wb.low, wc.low), inside = ivec3(wa.high, wb.high, wc.high) + ((low - t.whole.bias) >> 31);
      put_texel(t, first + ivec2(0, y),
                vec3(float_of(wa.high, wa.low, false), float_of(wb.high, wb.low, false), float_of(wc.high, wc.low, false)),
                t.has_area && (inside.x | inside.y | inside.z) >= 0);
    }
    a = stepped(a, t.a.down, 1);
    b = stepped(b, t.b.down, 1);
    c = stepped(c, t.c.down, 1);
  }
}

void draw(LaneTriangle t) {
  uint reached = subgroupBallot(reaches_block(block_edges(t.a, t.b, t.c, 0))).x |
                 subgroupBallot(reaches_block(block_edges(t.a, t.b, t.c, 1))).x << 8;
  while (reached != 0) {
    const int number = findLSB(reached);
    reached &= reached - 1;
    draw_block(t, block_position(number));
  }
}

// A map's side is a power of two and thus a whole number of tiles.
void main() {
  globals = globals_at(push.globals);
  set = RasterSetRef(push.set).value;
  const uvec3 group = layers_group();
  if (kSeveralWorlds) globals = globals_of_view(set, group.z);
  view = view_for_all(set.views, group.z);
  const ivec2 tile = ivec2(group.xy);
  tile_pixel = tile << kTileShift;
  if (tile_pixel.x >= view.width || tile_pixel.y >= view.height) return;
  uint next = UintRef(set.tile_lists).at[list_of_tile(view, tile)];
  while (next != 0) {
    const uint entry = next - 1;
    const TileTriangle whole = tile_triangle(prepared_for_all(set.prepared, TileEntryRef(set.tiles).at[entry].prepared));
    next = is_ended() ? 0 : UintRef(set.tile_next).at[entry];
    if (largest_edge_function(whole) < int64_t(1) << 48) {
      draw(lane_triangle(whole));
    } else {
      for (int i = 0; i < kTileSide * kTileSide / 8; ++i) {
        draw_tile_pixel(globals, set, view, whole,
                        tile_pixel + ivec2((i % (kTileSide / 8)) * 8 + gl_SubgroupInvocationID, i / (kTileSide / 8)));
      }
    }
  }
}
