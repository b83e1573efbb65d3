// Visibility buffer writes: depth in the upper half of 64 bits, id in the lower. The largest value wins, so
// the result does not depend on order: nearest first, then the larger id. With FIRE3DV_COUNT a sample counts
// its fragments instead.
#ifndef FIRE3DV_CAMERA_RASTER_GLSL
#define FIRE3DV_CAMERA_RASTER_GLSL
#extension GL_EXT_shader_atomic_int64 : require
#include "common/generations.glsl"
#include "common/visible_triangle.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer VisibilityRef { uint64_t at[]; };

uint64_t seen_value(float depth, uint id, uint generation) {
  return (uint64_t(encode_depth(depth, generation)) << 32) | id;
}

void put(RasterSet set, uint sample_index, float depth, uint id, bool read_before_write) {
  if (depth < 0) return;  // beyond the far plane
#ifdef FIRE3DV_COUNT
  atomicAdd(VisibilityRef(set.target).at[sample_index], uint64_t(1));
#else
  const uint64_t value = seen_value(depth, id, set.generation);
  VisibilityRef visibility = VisibilityRef(set.target);
  // The read saves the atomic where much is hidden; elsewhere it costs more than it saves.
  if (read_before_write && visibility.at[sample_index] >= value) return;
  atomicMax(visibility.at[sample_index], value);
#endif
}

int pixel_reach(RasterView view) { return 0; }

// Position of the alpha test: the pixel's centre, or the mean of the covered samples.
vec2 tested_position(ivec2 pixel, uint covered) {
#if FIRE3DV_SAMPLES == 4
  if (covered == 15) return vec2(pixel) + 0.5;
  vec2 sum = vec2(0);
  for (int s = 0; s < 4; ++s) if ((covered & (1u << s)) != 0) sum += vec2(kSamplePosition[s]) / 256;
  return vec2(pixel) + sum / bitCount(covered);
#else
  return vec2(pixel) + 0.5;
#endif
}

// Coverage and depth of a pixel's samples; 32-bit and 64-bit edge functions yield identical bits.
#define FIRE3DV_COVER_PIXEL(INT, IVEC)                                                                            \
  uint covered = 0;                                                                                               \
  float depth[FIRE3DV_SAMPLES];                                                                                   \
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {                                                                     \
    const ivec2 position = pixel * kSubpixels + kSamplePosition[s];                                                  \
    const IVEC from_a = IVEC(position - a.xy), from_b = IVEC(position - b.xy), from_c = IVEC(position - c.xy);             \
    const INT wa = INT(bc.x) * from_b.y - INT(bc.y) * from_b.x;                                                   \
    const INT wb = INT(ca.x) * from_c.y - INT(ca.y) * from_c.x;                                                   \
    const INT wc = INT(ab.x) * from_a.y - INT(ab.y) * from_a.x;                                                   \
    precise const float z = (float(wa) * a.z + float(wb) * b.z + float(wc) * c.z) * inverse_area;                 \
    depth[s] = z;                                                                                                 \
    if (wa >= INT(bias.x) && wb >= INT(bias.y) && wc >= INT(bias.z)) covered |= 1u << s;                          \
  }

#endif
