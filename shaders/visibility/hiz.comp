// HiZ pyramid of the visibility buffer: 64 x 64 pixels per workgroup, 4 x 4 per thread. Variants:
// FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "visibility/hiz.glsl"
#include "common/pixel_ids.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { HizPush push; };

const float kNone = 3.4e38;  // of a block without pixels
shared float farthest_of_thread[16][16];

void main() {
  const ivec2 size = ivec2(push.width, push.height);
  const ivec2 first = ivec2(gl_GlobalInvocationID.xy) * 4, thread = ivec2(gl_LocalInvocationID.xy);
  float farthest = kNone;
  for (int i = 0; i < 16; ++i) {
    const ivec2 pixel = first + ivec2(i & 3, i >> 2);
    if (pixel.x >= size.x || pixel.y >= size.y) continue;
    const uint sample_index = uint(pixel.y * size.x + pixel.x) * FIRE3DV_SAMPLES;
    for (uint s = 0; s < FIRE3DV_SAMPLES; ++s) {
      farthest = min(farthest, decode_depth(SampleRef(push.visibility).at[sample_index + s].y, push.generation));
    }
  }
  farthest_of_thread[thread.y][thread.x] = farthest;
  for (int level = 0; level < kHizLevels; ++level) {
    // A thread at a block's corner reduces four blocks of the previous level.
    const int half_step = 1 << level, step = 2 * half_step;
    barrier();
    if ((thread.x | thread.y) % step == 0) {
      farthest = min(min(farthest_of_thread[thread.y][thread.x], farthest_of_thread[thread.y][thread.x + half_step]),
                     min(farthest_of_thread[thread.y + half_step][thread.x],
                         farthest_of_thread[thread.y + half_step][thread.x + half_step]));
      farthest_of_thread[thread.y][thread.x] = farthest;
      const ivec2 blocks = blocks_of_level(size, level), block = first >> (kHizShift + level);
      if (block.x < blocks.x && block.y < blocks.y) {
        FloatsRef(push.hiz).at[first_of_level(size, level) + block.y * blocks.x + block.x] = farthest;
      }
    }
  }
}
