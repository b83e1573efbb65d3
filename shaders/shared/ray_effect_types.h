// GPU records of ray effects: reflections, ambient occlusion, refraction and one diffuse bounce, of visible
// surfaces.
#ifndef FIRE3DV_SHARED_RAY_EFFECT_TYPES_H
#define FIRE3DV_SHARED_RAY_EFFECT_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

#define FIRE3DV_RAY_EFFECT_REFLECTIONS 1u
#define FIRE3DV_RAY_EFFECT_OCCLUSION 2u
#define FIRE3DV_RAY_EFFECT_REFRACTION 4u
#define FIRE3DV_RAY_EFFECT_BOUNCE 8u

// Specialisation constant after those of bindings.h: diffuse rays are traced. Their code takes registers from
// all rays.
#define FIRE3DV_VARIANT_BOUNCES 6

// Result of a visible surface in a pixel, stored at the first sample that shows the surface. Half floats.
struct RayEffectRecord {
  uint reflected_rg;        // mean radiance of the rays that hit a surface, summed over hits only
  uint reflected_b_missed;  // blue; share of the lobe that takes the environment instead
  uint open_blur;  // share of the hemisphere that is not occluded; width of the reflection's blur in pixels
  uint normal;  // packSnorm4x8, world; w: eighths: 1 if occlusion was traced, 2 if light was refracted, 4 if
                // bounced
};

// Light that surfaces scatter diffusely: means over the rays of a pixel.
struct BouncedRecord {
  uint radiance_rg;  // of the rays that hit a surface, summed over hits only; half floats
  uint radiance_b;
  uint missed;  // of the environment, in the directions of the rays that hit none; shared exponent
  uint all;     // of the environment, in all directions
};

struct RayEffectsPush {
  FIRE3DV_ADDRESS globals;
  FIRE3DV_ADDRESS visibility;  // uint64_t[pixel][sample]
  // RayEffectRecord[pixel][sample], written. With refraction, uvec2[pixel][sample] follow: radiance and blur
  // as halves; then, with a bounce, BouncedRecord[pixel][sample].
  FIRE3DV_ADDRESS records;
  uint effects;          // FIRE3DV_RAY_EFFECT_*
  uint surface;          // the n-th distinct surface of each pixel
  uint reflection_rays;  // from a rough surface in a pixel
  uint occlusion_rays;
  uint bounce_rays;
  float occlusion_distance_m;
  float pixel_angle_rad;  // between neighbouring pixels, at the image's centre
};

FIRE3DV_SHARED_END
#endif
