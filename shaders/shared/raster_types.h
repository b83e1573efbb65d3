// Drawing clusters by compute.
#ifndef FIRE3DV_SHARED_RASTER_TYPES_H
#define FIRE3DV_SHARED_RASTER_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// From where clusters are culled and triangles drawn: the camera, or a light's map.
struct RasterView {
  mat4 clip_from_world;
  vec4 planes_world[6];  // inside where dot(xyz, p) + w >= 0
  vec4 eye_world;        // w = 1: a point; w = 0: an orthographic view, which looks along xyz
  uint width;
  uint height;
  uint first_texel;  // of the light's maps; of a camera the first sample
  // For shadow maps. Orthographic: metres for each unit of depth, and the side of a texel in metres.
  // Perspective: the near distance in metres, and the side of a texel at a distance of 1 m.
  float depth_m;
  float texel_m;
  // Of levels of detail: how many times the error that is allowed 1 m is, at a distance of 1 m in perspective
  // views. 0: everything as the file has it.
  float level_scale;
  uint first_tile;  // of the lists of tiles, where these are drawn one by one
  uint padding;
};

// A list of clusters, begun with the arguments of the dispatch that draws them: one row of groups, and `count` 0, or, where a
// device has no rows that long, several.
struct ClusterList {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint count;
};

struct ViewWork {
  ClusterList solid;
  ClusterList masked;
};

// Triangles too large for one thread: cut at the view's border if need be, then into tiles.
struct LargeWork {
  ClusterList expand;  // one group for each entry of `huge`
  ClusterList tiles;   // one group for each entry of `tiles`
  uint prepared_count;
  uint lost;  // triangles for which there was no room
};

struct HugeTriangle {
  uint id;
  uint view;
};

struct PreparedTriangle {
  ivec2 a, b, c;  // 1/256 pixel; in an order that makes the area positive
  float za, zb, zc;
  uint id;
  uint view;
};

#define FIRE3DV_TILE_SHIFT 5u  // tiles of 32 x 32 pixels

struct TileEntry {
  uint prepared;  // FIRE3DV_NO_INDEX = none
  uint tile;      // x | y << 16
};

// Where hidden clusters are left out, those that were seen in the frame before are drawn first. What is left
// is drawn unless it is behind these, for certain.
#define FIRE3DV_ROUND_ONLY 0u
#define FIRE3DV_ROUND_EARLY 1u
#define FIRE3DV_ROUND_LATE 2u

// In a list: triangles of the cluster are drawn on one side alone.
#define FIRE3DV_LISTED_ONE_SIDE 0x80000000u

#define FIRE3DV_CLEAR_QUADS 8u  // of a target, that a thread empties

// All that the raster shaders share for one set of views.
struct RasterSet {
  FIRE3DV_ADDRESS views;  // RasterView[]
  FIRE3DV_ADDRESS work;   // ViewWork[]
  // uint[view][cluster instance]: solid ones in front, masked ones at the back; with FIRE3DV_LISTED_ONE_SIDE
  FIRE3DV_ADDRESS lists;
  FIRE3DV_ADDRESS large;     // LargeWork
  FIRE3DV_ADDRESS huge;      // HugeTriangle[]
  FIRE3DV_ADDRESS prepared;  // PreparedTriangle[]
  FIRE3DV_ADDRESS tiles;     // TileEntry[]
  // Where triangles are drawn tile by tile (tiles_cpu.comp), else 0: uint[tile], an entry's place + 1, and
  // uint[entry], that of the next entry of its tile; 0 = none.
  FIRE3DV_ADDRESS tile_lists;
  FIRE3DV_ADDRESS tile_next;
  FIRE3DV_ADDRESS target;    // uint64_t[pixel][sample] of the camera; uint[] of the lights
  FIRE3DV_ADDRESS was_seen;  // uint[cluster instance]: 1 = in view and not hidden, by the frame before
  FIRE3DV_ADDRESS farthest;  // float[]: of blocks of pixels, see common/farthest_depth.glsl
  uint instance_count;
  uint huge_capacity;
  uint prepared_capacity;
  uint tile_capacity;
  uint cull;        // 0: every cluster is drawn
  uint round;       // FIRE3DV_ROUND_*
  uint look_first;  // 1: a light's texel is read before it is written, where waiting for a read costs less
  uint one_row;      // 1: see ClusterList
  uint cull_groups;  // of the dispatch that culls, in x and y, for each view; those behind them empty the target
  uint clear_quads;  // of 16 bytes, that these empty
  uint generation;   // of the target
};

// Steps between the values that depths of one drawing after the other are kept with, as bits on top of their own:
// see passes::ClusterTarget.
#define FIRE3DV_GENERATION 0x40000000u
#define FIRE3DV_LAST_GENERATION 0xc0000000u

struct FarthestDepthPush {
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS farthest;    // float[], written
  uint generation;             // of the visibility buffer
  uint width;                  // of the image
  uint height;
};

struct RasterPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS set;  // RasterSet
  uint view;
};

FIRE3DV_SHARED_END
#endif
