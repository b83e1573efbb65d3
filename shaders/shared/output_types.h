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

FIRE3DV_SHARED_END
#endif
