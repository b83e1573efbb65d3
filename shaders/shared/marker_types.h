// Parameters of the marker pass. The kinds are those of the wire's MarkerKind.
#ifndef FIRE3DV_SHARED_MARKER_TYPES_H
#define FIRE3DV_SHARED_MARKER_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_MARKER_POINTS 0u
#define FIRE3DV_MARKER_LINES 1u
#define FIRE3DV_MARKER_LINE_STRIP 2u
#define FIRE3DV_MARKER_ARROWS 3u
#define FIRE3DV_MARKER_AXES 4u
#define FIRE3DV_MARKER_BOXES 5u
#define FIRE3DV_MARKER_SPHERES 6u
#define FIRE3DV_MARKER_CYLINDERS 7u
#define FIRE3DV_MARKER_CAPSULES 8u
#define FIRE3DV_MARKER_TRIANGLES 9u

#define FIRE3DV_MARKER_IMAGES 11u

#define FIRE3DV_MARKER_WIDTH_IN_LENGTHS 1u
#define FIRE3DV_MARKER_ROTATION_EACH 2u  // one rotation per position; else one for all
#define FIRE3DV_MARKER_SIZE_EACH 4u
#define FIRE3DV_MARKER_COLOR_EACH 8u

struct MarkerPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS positions;  // vec3[], marker space
  FIRE3DV_ADDRESS rotations;  // vec4[], quaternions; 0: none
  FIRE3DV_ADDRESS sizes;      // vec3[]; 0: none
  FIRE3DV_ADDRESS colors;     // uint[], sRGB and alpha; 0: white
  FIRE3DV_ADDRESS target;     // LayerTarget, like the members behind `rings` for layers alone
  AffineRows world_from_marker;
  float width;  // pixels, or world lengths with FIRE3DV_MARKER_WIDTH_IN_LENGTHS
  uint kind;
  uint flags;
  uint segments;  // of round shapes, around z; of images the width in pixels
  uint rings;     // of spheres and of both halves of capsules, even; of images the height in pixels
  uint pass;
  uint first_number;  // of the triangles; see FIRE3DV_LAYER_NUMBER_BITS
  uint triangles;     // of an instance
};

FIRE3DV_SHARED_END
#endif
