// Tracing of the rays of one list entry. See light_rays.glsl for the functions that the including shader
// defines.
#ifndef FIRE3DV_TRACE_ENTRY_GLSL
#define FIRE3DV_TRACE_ENTRY_GLSL
#include "shading/light_rays.glsl"
#include "shading/shadow_points.glsl"

void trace_entry(GlobalsRef globals, uint64_t visibility, RayEntry entry) {
  const PixelIds ids = pixel_ids(globals, visibility, entry.pixel);
  uint lit = 0;
  uint open = kAllSamples & ~samples_with(ids, 0);
  while (open != 0) {
    const int s = findLSB(open);
    const uint id = id_of_sample(ids, s), same = samples_with(ids, id);
    open &= ~same;
    // Each light has one bit per sample, or the whole word.
    if ((entry.wanted & (FIRE3DV_SAMPLES == 4 ? 0x11111111u << s : 0xffffffffu)) == 0) continue;
    const SurfacePoint point = shadow_point(globals, id, same, entry.pixel);
    for (uint i = 0; i < globals.value.light_count; ++i) {
      const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[i];
      const uint bit = 1u << (shadow.rays == 1 ? shadow.mask_shift + s : s);
      if (shadow.mask_word != entry.word || (entry.wanted & bit) == 0) continue;
      const LightSample light = sample_light(globals, i, point.position_world);
      const ShadowRay ray = shadow_ray(globals, point, i, light);
      const float arrives = light_that_arrives(globals, shadow, i, ray.light, ray.origin, entry.pixel);
      if (shadow.rays == 1) {
        if (arrives > 0) lit |= same << shadow.mask_shift;
      } else {
        for (int other = 0; other < FIRE3DV_SAMPLES; ++other) {
          if ((same & (1u << other)) != 0) lit |= uint(arrives * 255 + 0.5) << (8 * other);
        }
      }
    }
  }
  // Only this entry writes the word.
  if (lit != 0) UintsRef(globals.value.shadow_mask).at[entry.pixel * globals.value.mask_words + entry.word] |= lit;
}

#endif
