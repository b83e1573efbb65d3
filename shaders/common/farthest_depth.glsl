// The farthest depth of blocks of 8 x 8 pixels and of squares twice, four and eight times as large: behind it nothing of
// the block can be seen. Depth is reversed, so the farthest is the least.
#ifndef FIRE3DV_FARTHEST_DEPTH_GLSL
#define FIRE3DV_FARTHEST_DEPTH_GLSL
#include "common/buffers.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FloatsRef { float at[]; };

const int kFarthestShift = 3;   // of the smallest blocks
const int kFarthestLevels = 4;

ivec2 blocks_of_level(ivec2 size, int level) {
  const int shift = kFarthestShift + level;
  return (size + (1 << shift) - 1) >> shift;
}

// Where a level begins in the array; levels lie one after the other.
int first_of_level(ivec2 size, int level) {
  int first = 0;
  for (int i = 0; i < level; ++i) {
    const ivec2 blocks = blocks_of_level(size, i);
    first += blocks.x * blocks.y;
  }
  return first;
}

#endif
