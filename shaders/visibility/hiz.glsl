// Hierarchical depth (HiZ) pyramid layout: farthest depth of blocks of 8 x 8, 16 x 16, 32 x 32 and 64 x 64
// pixels. Surfaces behind that depth are hidden in the block. Depth is reversed, so the farthest is the
// minimum.
#ifndef FIRE3DV_HIZ_GLSL
#define FIRE3DV_HIZ_GLSL
#include "common/buffers.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FloatsRef { float at[]; };

const int kHizShift = 3;   // of the smallest blocks
const int kHizLevels = 4;

ivec2 blocks_of_level(ivec2 size, int level) {
  const int shift = kHizShift + level;
  return (size + (1 << shift) - 1) >> shift;
}

// Offset of a level in the array; levels are stored in sequence.
int first_of_level(ivec2 size, int level) {
  int first = 0;
  for (int i = 0; i < level; ++i) {
    const ivec2 blocks = blocks_of_level(size, i);
    first += blocks.x * blocks.y;
  }
  return first;
}

#endif
