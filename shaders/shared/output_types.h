// Planes of numbers beside an image's colour: what each pixel shows, how far away and where it moves.
#ifndef FIRE3DV_SHARED_OUTPUT_TYPES_H
#define FIRE3DV_SHARED_OUTPUT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Of a part.
struct PartLabels {
  uint instance;
  uint semantic;
};

// What one image wants. Planes are rows from the top without gaps; an address of 0: not wanted.
struct OutputsWanted {
  FIRE3DV_ADDRESS depth;     // float[pixel]
  FIRE3DV_ADDRESS instance;  // uint[pixel]
  FIRE3DV_ADDRESS semantic;  // uint[pixel]
  FIRE3DV_ADDRESS normal;    // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS motion;    // vec2[pixel]
  FIRE3DV_ADDRESS labels;    // PartLabels[part]
  // AffineRows[node], when the camera's last image was taken; 0: it has taken none.
  FIRE3DV_ADDRESS last_world_from_node;
  mat4 last_clip_from_world;
  vec3 look_world;  // unit
  uint orthographic;
};

struct OutputsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  FIRE3DV_ADDRESS wanted;      // OutputsWanted
};

// An image through a lens, and the pinhole's that it is taken from. Addresses of 0: not wanted. Planes as above.
struct LensWanted {
  FIRE3DV_ADDRESS color_in, color_out;  // uint[pixel]: four bytes
  FIRE3DV_ADDRESS linear_in, linear_out;  // uvec2[pixel]: four half floats
  FIRE3DV_ADDRESS depth_in, depth_out;
  FIRE3DV_ADDRESS instance_in, instance_out;  // in: wherever depth is wanted, too
  FIRE3DV_ADDRESS semantic_in, semantic_out;
  FIRE3DV_ADDRESS normal_in, normal_out;
  FIRE3DV_ADDRESS motion_in, motion_out;
  uint width, height, width_in, height_in;  // pixels
  vec2 focal, middle, focal_in, middle_in;  // pixels; the middle of the upper left one is (0, 0)
  vec4 coefficients;                        // of the lens, the first four
  float last_coefficient;
  float largest_radius;
  uint fisheye;  // 0: plumb_bob
};

struct LensPush {
  FIRE3DV_ADDRESS wanted;  // LensWanted
};

FIRE3DV_SHARED_END
#endif
