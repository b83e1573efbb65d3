// What a pipeline is made for: code for anything else takes registers, and so pixels in flight, and a CPU's time.
#ifndef FIRE3DV_MADE_FOR_GLSL
#define FIRE3DV_MADE_FOR_GLSL
#include "shared/bindings.h"
#include "shared/light_types.h"

// How shadows are found, where that is known. Else, as in pipelines that are not told, as the globals say.
layout(constant_id = FIRE3DV_MADE_FOR_SHADOWS) const uint kShadows = FIRE3DV_SHADOWS_ANY;
// False: for scenes whose materials have none; of which nothing is alpha-masked; of which no texture takes the second set.
layout(constant_id = FIRE3DV_MADE_FOR_TEXTURES) const bool kTextures = true;
layout(constant_id = FIRE3DV_MADE_FOR_MASKS) const bool kMasks = true;
layout(constant_id = FIRE3DV_MADE_FOR_SECOND_UV) const bool kSecondUv = true;

#endif
