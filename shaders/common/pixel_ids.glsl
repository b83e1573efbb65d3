// What the visibility buffer says of a pixel, triangle by triangle.
#ifndef FIRE3DV_PIXEL_IDS_GLSL
#define FIRE3DV_PIXEL_IDS_GLSL
#include "common/raster_rules.glsl"
#include "common/sample_place.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleRef { uvec2 at[]; };  // id, depth

struct PixelIds {
  uint at[FIRE3DV_SAMPLES];  // of each sample; 0 = background
};

PixelIds pixel_ids(uint64_t visibility, uint pixel) {
  PixelIds ids;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) ids.at[s] = SampleRef(visibility).at[pixel * FIRE3DV_SAMPLES + s].x;
  return ids;
}

// Samples of this one's triangle, as bits; 0 when an earlier sample stands for it.
uint samples_of_triangle(PixelIds ids, int first) {
  uint same = 0;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    if (ids.at[s] != ids.at[first]) continue;
    if (s < first) return 0;
    same |= 1u << s;
  }
  return same;
}

// Where in the image the triangle is looked at, in pixels.
vec2 place_of_samples(uvec2 pixel, uint same) {
#if FIRE3DV_SAMPLES == 4
  return vec2(pixel) + 0.5 + sample_place(same);
#else
  return vec2(pixel) + 0.5;
#endif
}

#endif
