// Specialisation constants of a pipeline. Unused code would cost registers, and thus occupancy, and CPU time.
#ifndef FIRE3DV_SCENE_VARIANT_GLSL
#define FIRE3DV_SCENE_VARIANT_GLSL
#include "shared/bindings.h"
#include "shared/light_types.h"

// Shadow technique; FIRE3DV_SHADOWS_ANY reads it from the globals.
layout(constant_id = FIRE3DV_VARIANT_SHADOWS) const uint kShadows = FIRE3DV_SHADOWS_ANY;
// False for scenes without textures, without alpha-masked materials, and without uses of the second texture
// coordinates.
layout(constant_id = FIRE3DV_VARIANT_TEXTURES) const bool kTextures = true;
layout(constant_id = FIRE3DV_VARIANT_MASKS) const bool kMasks = true;
layout(constant_id = FIRE3DV_VARIANT_SECOND_UV) const bool kSecondUv = true;

#endif
