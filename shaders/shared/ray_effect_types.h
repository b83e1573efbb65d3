// GPU records of ray effects: reflections, ambient occlusion and refraction of visible surfaces.
#ifndef FIRE3DV_SHARED_RAY_EFFECT_TYPES_H
#define FIRE3DV_SHARED_RAY_EFFECT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_RAY_EFFECT_REFLECTIONS 1u
#define FIRE3DV_RAY_EFFECT_OCCLUSION 2u
#define FIRE3DV_RAY_EFFECT_REFRACTION 4u

// Result of a visible surface in a pixel, stored at the first sample that shows the surface. Half floats.
struct RayEffectRecord {
  uint reflected_rg;    // mean radiance of the rays that hit a surface, summed over hits only
  uint reflected_b_missed;  // blue; share of the lobe that takes the environment instead
  uint open_blur;       // share of the hemisphere that is not occluded; width of the reflection's blur in pixels
  uint normal;          // packSnorm4x8, world; w: 1/4 if occlusion was traced, plus 1/2 if light was refracted
};

struct RayEffectsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  // RayEffectRecord[pixel][sample], written; with refraction, uvec2[pixel][sample] follow: radiance and blur as halves.
  FIRE3DV_ADDRESS records;
  uint effects;                // FIRE3DV_RAY_EFFECT_*
  uint surface;                // the n-th distinct surface of each pixel
  uint reflection_rays;        // from a rough surface in a pixel
  uint occlusion_rays;
  float occlusion_distance_m;
  float pixel_angle_rad;       // between neighbouring pixels, at the image's centre
};

FIRE3DV_SHARED_END
#endif
