// Shadow mask lookup: results of shadow rays, read during shading.
#ifndef FIRE3DV_SHADOW_MASK_GLSL
#define FIRE3DV_SHADOW_MASK_GLSL
#include "common/buffers.glsl"
#include "common/scene_variant.glsl"

uint shadows_of(GlobalsRef globals) { return kShadows == FIRE3DV_SHADOWS_ANY ? globals.value.shadows : kShadows; }

float mask_visibility(GlobalsRef globals, LightShadow shadow, uint pixel, int sample_index) {
  if (shadow.rays == 0) return 1;
  const uint word = UintRef(globals.value.shadow_mask).at[pixel * globals.value.mask_words + shadow.mask_word];
  if (shadow.rays == 1) return (word >> (shadow.mask_shift + sample_index)) & 1;
  return ((word >> (8 * sample_index)) & 255) / 255.0;
}

#endif
