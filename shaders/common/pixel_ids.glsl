// Per-pixel decoding of the visibility buffer into ids and depths.
#ifndef FIRE3DV_PIXEL_IDS_GLSL
#define FIRE3DV_PIXEL_IDS_GLSL
#include "common/generations.glsl"
#include "visibility/raster_rules.glsl"
#include "common/mean_sample_position.glsl"

// id, encode_depth()
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleRef { uvec2 at[]; };

// Ids of a pixel's samples; 0: background. One vector, because a dynamically indexed array would live in
// memory.
#if FIRE3DV_SAMPLES == 4
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer SamplePairRef { uvec4 at[]; };
#define PixelIds uvec4
const uint kAllSamples = 15;

PixelIds pixel_ids(GlobalsRef globals, uint64_t visibility, uint pixel) {
  SamplePairRef pairs = SamplePairRef(visibility);
  const uvec4 low = pairs.at[2 * pixel], high = pairs.at[2 * pixel + 1];
  const bvec4 is_new = greaterThanEqual(uvec4(low.yw, high.yw), uvec4(globals.value.visibility_generation));
  return mix(uvec4(0), uvec4(low.xz, high.xz), is_new);
}

vec4 pixel_depths(GlobalsRef globals, uint64_t visibility, uint pixel) {
  SamplePairRef pairs = SamplePairRef(visibility);
  const uvec4 low = pairs.at[2 * pixel], high = pairs.at[2 * pixel + 1];
  return decode_depth(uvec4(low.yw, high.yw), globals.value.visibility_generation);
}

uint id_of_sample(PixelIds ids, int s) { return s < 2 ? (s == 0 ? ids.x : ids.y) : (s == 2 ? ids.z : ids.w); }

// Bit mask of the samples with this id.
uint samples_with(PixelIds ids, uint id) {
  return (ids.x == id ? 1u : 0u) | (ids.y == id ? 2u : 0u) | (ids.z == id ? 4u : 0u) | (ids.w == id ? 8u : 0u);
}
#else
#define PixelIds uint
const uint kAllSamples = 1;

PixelIds pixel_ids(GlobalsRef globals, uint64_t visibility, uint pixel) {
  const uvec2 seen = SampleRef(visibility).at[pixel];
  return seen.y >= globals.value.visibility_generation ? seen.x : 0;
}
uint id_of_sample(PixelIds ids, int s) { return ids; }
uint samples_with(PixelIds ids, uint id) { return ids == id ? 1u : 0u; }
#endif

// Image position at which the triangle is evaluated, in pixels.
vec2 position_of_samples(uvec2 pixel, uint same) {
#if FIRE3DV_SAMPLES == 4
  return vec2(pixel) + 0.5 + mean_sample_position(same);
#else
  return vec2(pixel) + 0.5;
#endif
}

#endif
