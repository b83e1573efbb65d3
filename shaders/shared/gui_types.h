// What draws panels is told.
#ifndef FIRE3DV_SHARED_GUI_TYPES_H
#define FIRE3DV_SHARED_GUI_TYPES_H
#include "basics.h"

#define FIRE3DV_GUI_TILE 8u  // pixels along a side
// Of workgroups: every device takes that many.
#define FIRE3DV_GUI_TILES_IN_ROW 32768u
#define FIRE3DV_GUI_RECTANGLE 0u
#define FIRE3DV_GUI_TRIANGLE 1u

FIRE3DV_SHARED_BEGIN

// Pixels of the image. A rectangle lies between corners a and b, and has one colour; c is not read.
struct GuiPrimitive {
  vec4 a;  // place, and where in the texture
  vec4 b;
  vec4 c;
  vec4 clip;     // least x and y, and where it ends
  uint color_a;  // 8 bits each: red lowest, then green, blue, alpha
  uint color_b;
  uint color_c;
  uint kind;
};

struct GuiTile {
  uint place;  // x in the lower half, y in the upper, in tiles
  uint first;  // of its entries
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
