// Parameters of the inspection passes: picking, debug views and outline.
#ifndef FIRE3DV_SHARED_INSPECT_TYPES_H
#define FIRE3DV_SHARED_INSPECT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Surface at the picked pixel.
struct PickedSurface {
  AffineRows world_from_node;  // of the picked image
  vec3 world;
  float depth_m;   // along the view direction; infinite for the background
  uint part;       // primitive instance; FIRE3DV_NO_INDEX: the background
  uint transform;  // PartRecord::node
};

struct PickPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS picked;      // PickedSurface, written
  vec3 look_world;             // unit view direction
  uint orthographic;
  uint x;
  uint y;
};

#define FIRE3DV_DEBUG_NORMALS 1u
#define FIRE3DV_DEBUG_DEPTH 2u
#define FIRE3DV_DEBUG_INSTANCES 3u
#define FIRE3DV_DEBUG_CLUSTERS 4u
#define FIRE3DV_DEBUG_OVERDRAW 5u
#define FIRE3DV_DEBUG_DEPTH_RANGE 6u  // before the depth view: finds the range, writes no image

// Depth range of an image, as bits of positive floats, which order like the floats.
struct DepthRange {
  uint inverse_nearest;  // complement, so that clearing to 0 makes the range empty
  uint farthest;
};

struct DebugViewPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS counts;      // uint64_t[pixel], overdraw counts
  FIRE3DV_ADDRESS range;       // DepthRange
  FIRE3DV_ADDRESS nodes;       // uint[part], in the view of instances
  vec3 look_world;             // unit view direction
  uint orthographic;
  uint view;  // FIRE3DV_DEBUG_*
};

struct UnresolvedPixelsPush {
  FIRE3DV_ADDRESS lists;    // RayList[FIRE3DV_RAY_LISTS]
  FIRE3DV_ADDRESS entries;  // RayEntry[]
  uint width;               // of the image
  uint height;
  uint marks;  // 0: turns the image grey; 1: marks the listed pixels
};

struct OutlinePush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS selected;    // uint[]: one bit per part
};

FIRE3DV_SHARED_END
#endif
