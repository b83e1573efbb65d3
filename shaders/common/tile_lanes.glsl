// Draws triangles into a tile of 32 x 32 pixels eight samples at a time, for devices that are a CPU (see lanes.glsl): the same
// samples with the same depths, to the bit, as by FIRE3DV_COVER_PIXEL and FIRE3DV_COVER_TEXEL, but with 32 bits.
//
// An edge function E is a whole number and stays below 2^54 (see largest_edge_function()). It is kept in two parts, E = high * 2^24
// + low with low >= 0. Steps from pixel to pixel are kept so, too, and parts are added to parts; after the fewer than 64 steps
// across a tile what has gathered in low still fits, and low >> 24 of it belongs to high. Then E >= 0 exactly where high >= 0.
//
// A depth wants float(E), rounded once. Both parts as floats are exact while they are below 2^24, so their sum is rounded
// once, too. Where a triangle covers a sample no E is larger than twice its area; see float_of() for areas from 2^48 on.
#ifndef FIRE3DV_TILE_LANES_GLSL
#define FIRE3DV_TILE_LANES_GLSL
#include "common/tile_raster.glsl"

const int kTileSide = 1 << kTileShift;
const int kBlock = 8;                                                         // pixels along a block of a tile
const int kBlocksAcross = kTileSide / kBlock;                                 // so a lane for each block of half a tile
const float kBlockReach = kFirstSample == kLastSample ? kBlock - 1 : kBlock;  // pixels to a block's last sample, at least
const int kVectorPixels = 8 / FIRE3DV_SAMPLES;                                // side by side; their samples are a vector's lanes

struct Parts {
  int high, low;
};

Parts parts_of(int64_t e) { return Parts(int(e >> 24), int(e) & 0xffffff); }
Parts stepped(Parts p, Parts step, int times) { return Parts(p.high + step.high * times, p.low + step.low * times); }
Parts carried(Parts p) { return Parts(p.high + (p.low >> 24), p.low & 0xffffff); }

// wide: of E from 2^48 on the last bit of a float is 2^25 or more. What lies below 2^8 only has to be told from nothing then.
float float_of(int high, int low, const bool wide) {
  precise float sum = float(high) * 16777216.0 + float(low);
  if (wide && high >= 1 << 24) {
    const int middle = ((high & 255) << 16) + (low >> 8);
    sum = float(high >> 8) * 4294967296.0 + float(middle | min(low & 255, 1)) * 256.0;
  }
  return sum;
}

// One edge of a triangle. start: E at the lane's sample of the tile's first pixels, less a bias, so that the edge covers what is
// not negative.
struct LaneEdge {
  Parts start;
  Parts right;  // to the vector's next pixels
  Parts down;   // to the next row
  Parts block_right, block_down;
  // About the same at the tile's first sample, for whole blocks. slack: more than what rounding makes of it.
  float near_start, near_right, near_down, slack;
};

// tile_place, own_place: of the tile, and of the lane's sample from there, in 1/256 pixel.
LaneEdge lane_edge(ivec2 from, ivec2 to, int64_t bias, ivec2 tile_place, ivec2 own_place) {
  const ivec2 d = to - from, first = tile_place - from + kFirstSample, own = tile_place - from + own_place;
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

ivec2 block_place(int number) { return ivec2(number % kBlocksAcross, number / kBlocksAcross); }

// Three edges at once, at the first sample of the block with the lane's number, or of the one eight further.
struct BlockEdges {
  vec3 first, right, down, slack;
};

BlockEdges block_edges(LaneEdge a, LaneEdge b, LaneEdge c, const int half_tile) {
  const ivec2 pixel = block_place(int(gl_SubgroupInvocationID) + 8 * half_tile) * kBlock;
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

// No E is larger in a tile that the triangle's box reaches, nor with what a light's map adds to it.
int64_t largest_edge_function(TileTriangle t) {
  const ivec2 a = t.a.xy, b = t.b.xy, c = t.c.xy;
  const ivec2 extent = max(a, max(b, c)) - min(a, min(b, c)) + (kTileSide + 2) * kSubpixels;
  return 2 * int64_t(extent.x) * extent.y;
}

#endif
