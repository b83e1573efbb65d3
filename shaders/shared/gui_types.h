// Parameters and records of the GUI pass.
#ifndef FIRE3DV_SHARED_GUI_TYPES_H
#define FIRE3DV_SHARED_GUI_TYPES_H
#include "basics.h"

#define FIRE3DV_GUI_TILE 8u  // pixels along a side
// Workgroups in a row; every device supports that many.
#define FIRE3DV_GUI_TILES_IN_ROW 32768u
#define FIRE3DV_GUI_RECTANGLE 0u
#define FIRE3DV_GUI_TRIANGLE 1u

FIRE3DV_SHARED_BEGIN

// In image pixels. A rectangle spans corners a and b in one colour; c is not read.
struct GuiPrimitive {
  vec4 a;  // xy: position; zw: texture coordinates
  vec4 b;
  vec4 c;
  vec4 clip;     // xy: minimum; zw: end
  uint color_a;  // 8 bits each: red lowest, then green, blue, alpha
  uint color_b;
  uint color_c;
  uint kind;
};

struct GuiTile {
  uint tile_position;  // in tiles: x in the lower half, y in the upper
  uint first;          // first entry
  uint count;
};

struct GuiPush {
  FIRE3DV_ADDRESS primitives;  // GuiPrimitive[]
  FIRE3DV_ADDRESS tiles;       // GuiTile[]
  FIRE3DV_ADDRESS entries;     // uint[]
  uint tile_count;
  uint width;
  uint height;
};

FIRE3DV_SHARED_END
#endif
