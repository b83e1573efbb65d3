// GPU records of cluster culling and the compute rasteriser.
#ifndef FIRE3DV_SHARED_RASTER_TYPES_H
#define FIRE3DV_SHARED_RASTER_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// View for culling and raster: the camera, or a shadow map of a light.
struct RasterView {
  mat4 clip_from_world;
  vec4 planes_world[6];  // inside where dot(xyz, p) + w >= 0
  vec4 eye_world;        // w = 1: a position; w = 0: an orthographic view along xyz
  uint width;
  uint height;
  uint first_texel;  // in the lights' maps; for a camera, its first sample
  // For shadow maps. Orthographic: metres per unit of depth, and a texel's side in metres. Perspective: the
  // near distance in metres, and a texel's side at a distance of 1 m.
  float depth_m;
  float texel_m;
  // LOD selection: 1 m divided by the allowed error, at a distance of 1 m in perspective views. 0: LOD 0
  // only.
  float level_scale;
  uint first_tile;    // in the per-tile lists of the CPU variants
  uint surface_only;  // 1: LOD selection by the error of positions alone; cameras, solid surfaces
};

// Cluster list with its indirect dispatch arguments in front. The dispatch has one row of groups and `count`
// 0, or several rows where the device limits a row.
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

// Triangles too large for one thread: clipped if necessary, then split into tiles.
struct LargeWork {
  ClusterList expand;  // one group per entry of `huge`
  ClusterList tiles;   // one group per entry of `tiles`
  uint prepared_count;
  uint lost;  // triangles dropped for lack of room
};

struct HugeTriangle {
  uint id;
  uint view;
};

struct PreparedTriangle {
  ivec2 a, b, c;  // 1/256 pixel; in an order of positive area
  float za, zb, zc;
  uint id;
  uint view;
};

#define FIRE3DV_TILE_SHIFT 5u  // tiles of 32 x 32 pixels

struct TileEntry {
  uint prepared;  // FIRE3DV_NO_INDEX: none
  uint tile;      // x | y << 16
};

// Rounds of two-pass occlusion culling. EARLY draws the clusters visible in the last frame. LATE draws the
// others, unless the HiZ pyramid proves them hidden.
#define FIRE3DV_ROUND_ONLY 0u
#define FIRE3DV_ROUND_EARLY 1u
#define FIRE3DV_ROUND_LATE 2u

// List entry flag: only one side of the cluster's triangles is drawn.
#define FIRE3DV_LISTED_ONE_SIDE 0x80000000u

#define FIRE3DV_CLEAR_QUADS 8u  // 16-byte quads of a target that one thread clears

// Shared parameters of the raster shaders for one set of views.
struct RasterSet {
  FIRE3DV_ADDRESS views;  // RasterView[]
  FIRE3DV_ADDRESS work;   // ViewWork[]
  // uint[view][cluster instance]: solid at the front, masked at the back; with FIRE3DV_LISTED_ONE_SIDE
  FIRE3DV_ADDRESS lists;
  FIRE3DV_ADDRESS large;     // LargeWork
  FIRE3DV_ADDRESS huge;      // HugeTriangle[]
  FIRE3DV_ADDRESS prepared;  // PreparedTriangle[]
  FIRE3DV_ADDRESS tiles;     // TileEntry[]
  // Per-tile lists of visibility/tiles_cpu.comp, otherwise 0. tile_lists: uint[tile], first entry + 1.
  // tile_next: uint[entry], next entry + 1 of the tile; 0: none.
  FIRE3DV_ADDRESS tile_lists;
  FIRE3DV_ADDRESS tile_next;
  FIRE3DV_ADDRESS target;       // uint64_t[pixel][sample] of the camera; uint[] of the lights
  FIRE3DV_ADDRESS was_visible;  // uint[cluster instance]: 1 = visible in the last frame
  FIRE3DV_ADDRESS hiz;          // float[]: HiZ pyramid, see visibility/hiz.glsl
  FIRE3DV_ADDRESS
  view_globals;  // FIRE3DV_ADDRESS[view]: Globals of the view's world, where there are several
  uint instance_count;
  uint huge_capacity;
  uint prepared_capacity;
  uint tile_capacity;
  uint cull;               // 0: every cluster is drawn
  uint round;              // FIRE3DV_ROUND_*
  uint read_before_write;  // 1: reads a light's texel before the write, where read latency costs less
  uint one_row;            // 1: see ClusterList
  uint cull_groups;        // culling groups in x and y, per view; later groups clear the target
  uint clear_quads;        // 16-byte quads to clear
  uint generation;         // of the target
};

// Step between the generations of stored depths, in their two top bits. See passes::ClusterTarget.
#define FIRE3DV_GENERATION 0x40000000u
#define FIRE3DV_LAST_GENERATION 0xc0000000u

struct HizPush {
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS hiz;         // float[], written
  uint generation;             // of the visibility buffer
  uint width;                  // of the image
  uint height;
};

struct RasterPush {
  FIRE3DV_ADDRESS globals;  // of all views, or with several worlds of `view`
  FIRE3DV_ADDRESS set;      // RasterSet
  uint view;
};

FIRE3DV_SHARED_END
#endif
