// Tile raster with eight samples at a time, for devices that are a CPU (see lanes.glsl). It uses 32-bit
// arithmetic and matches FIRE3DV_COVER_PIXEL and FIRE3DV_COVER_TEXEL bit for bit.
#ifndef FIRE3DV_TILE_LANES_GLSL
#define FIRE3DV_TILE_LANES_GLSL
#include "visibility/tile_raster.glsl"

const int kTileSide = 1 << kTileShift;
const int kBlock = 8;  // pixels along a block of a tile
const int kBlocksAcross = kTileSide / kBlock;  // one lane per block of half a tile
// upper bound of the distance to a block's last sample, in pixels
const float kBlockReach = kFirstSample == kLastSample ? kBlock - 1 : kBlock;
const int kVectorPixels = 8 / FIRE3DV_SAMPLES;  // adjacent; their samples are a vector's lanes

// An edge function E, an integer below 2^54 (see largest_edge_function()): E = high * 2^24 + low, low >= 0.
// Steps use the same form. Across the fewer than 64 steps of a tile, low does not overflow; low >> 24 is
// carried into high. E >= 0 exactly where high >= 0.
// A depth needs float(E), rounded once. Both parts are exact floats below 2^24, so their sum is rounded once,
// too. No E of a covered sample exceeds twice the area; see float_of() for areas from 2^48 on.
struct Parts {
  int high, low;
};

Parts parts_of(int64_t e) { return Parts(int(e >> 24), int(e) & 0xffffff); }
Parts stepped(Parts p, Parts step, int times) { return Parts(p.high + step.high * times, p.low + step.low * times); }
Parts carried(Parts p) { return Parts(p.high + (p.low >> 24), p.low & 0xffffff); }

// wide: for E from 2^48 on, the last bit of a float is at least 2^25. Bits below 2^8 then only matter as
// sticky bits.
float float_of(int high, int low, const bool wide) {
  precise float sum = float(high) * 16777216.0 + float(low);
  if (wide && high >= 1 << 24) {
    const int middle = ((high & 255) << 16) + (low >> 8);
    sum = float(high >> 8) * 4294967296.0 + float(middle | min(low & 255, 1)) * 256.0;
  }
  return sum;
}

// One edge of a triangle. start: E at the lane's sample of the tile's first pixels, less a bias, so that
// covered means not negative.
struct LaneEdge {
  Parts start;
  Parts right;  // to the vector's next pixels
  Parts down;   // to the next row
  Parts block_right, block_down;
  // Approximate E at the tile's first sample, for block tests. slack: bound of its rounding error.
  float near_start, near_right, near_down, slack;
};

// tile_position: of the tile; own_position: of the lane's sample relative to it; both in 1/256 pixel.
LaneEdge lane_edge(ivec2 from, ivec2 to, int64_t bias, ivec2 tile_position, ivec2 own_position) {
  const ivec2 d = to - from, first = tile_position - from + kFirstSample, own = tile_position - from + own_position;
  LaneEdge edge;
  edge.start = parts_of(int64_t(d.x) * own.y - int64_t(d.y) * own.x - bias);
  edge.right = parts_of(int64_t(-d.y) * (kSubpixels * kVectorPixels));
  edge.down = parts_of(int64_t(d.x) * kSubpixels);
  edge.block_right = parts_of(int64_t(-d.y) * (kSubpixels * kBlock));
  edge.block_down = parts_of(int64_t(d.x) * (kSubpixels * kBlock));
  const float by_x = float(d.x) * float(first.y), by_y = float(d.y) * float(first.x);
  edge.near_start = by_x - by_y - float(bias);
  edge.near_right = -float(d.y) * kSubpixels;
  edge.near_down = float(d.x) * kSubpixels;
  edge.slack = 1e-6 * (abs(by_x) + abs(by_y) + abs(float(bias)) + (abs(edge.near_right) + abs(edge.near_down)) * kTileSide);
  return edge;
}

Parts at_block(LaneEdge edge, ivec2 block) {
  return stepped(stepped(edge.start, edge.block_right, block.x), edge.block_down, block.y);
}

ivec2 block_position(int number) { return ivec2(number % kBlocksAcross, number / kBlocksAcross); }

// Approximate values of three edges at the first sample of the lane's block; half_tile 1 selects the block
// eight further.
struct BlockEdges {
  vec3 first, right, down, slack;
};

BlockEdges block_edges(LaneEdge a, LaneEdge b, LaneEdge c, const int half_tile) {
  const ivec2 pixel = block_position(int(gl_SubgroupInvocationID) + 8 * half_tile) * kBlock;
  BlockEdges edges;
  edges.right = vec3(a.near_right, b.near_right, c.near_right);
  edges.down = vec3(a.near_down, b.near_down, c.near_down);
  edges.first = vec3(a.near_start, b.near_start, c.near_start) + edges.right * pixel.x + edges.down * pixel.y;
  edges.slack = vec3(a.slack, b.slack, c.slack);
  return edges;
}

vec3 most_of(BlockEdges e) { return e.first + max(e.right * kBlockReach, 0) + max(e.down * kBlockReach, 0); }
vec3 least_of(BlockEdges e) { return e.first + min(e.right * kBlockReach, 0) + min(e.down * kBlockReach, 0); }
bool reaches_block(BlockEdges e) { return all(greaterThanEqual(most_of(e), -e.slack)); }

// Upper bound of E in all tiles of the triangle's box, including the dilation of a light's map.
int64_t largest_edge_function(TileTriangle t) {
  const ivec2 a = t.a.xy, b = t.b.xy, c = t.c.xy;
  const ivec2 extent = max(a, max(b, c)) - min(a, min(b, c)) + (kTileSide + 2) * kSubpixels;
  return 2 * int64_t(extent.x) * extent.y;
}

#endif
