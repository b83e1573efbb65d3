// What a pipeline is made for: code for anything else takes registers, and so pixels in flight, and a CPU's time.
#ifndef FIRE3DV_MADE_FOR_GLSL
#define FIRE3DV_MADE_FOR_GLSL
#include "shared/light_types.h"

// How shadows are found, where that is known. Else, as in pipelines that are not told, as the globals say.
layout(constant_id = 0) const uint kShadows = FIRE3DV_SHADOWS_ANY;
layout(constant_id = 1) const bool kTextures = true;  // false: for scenes whose materials have none
layout(constant_id = 3) const bool kSecondUv = true;  // false: for scenes of which no texture takes the second set
layout(constant_id = 2) const bool kMasks = true;     // false: for scenes of which nothing is alpha-masked

#endif
