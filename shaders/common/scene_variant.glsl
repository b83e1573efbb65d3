// Specialisation constants of a pipeline. Unused code would cost registers, and thus occupancy, and CPU time.
#ifndef FIRE3DV_SCENE_VARIANT_GLSL
#define FIRE3DV_SCENE_VARIANT_GLSL
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/bindings.h"
#include "shared/light_types.h"
#include "shared/material_types.h"

// Shadow technique; FIRE3DV_SHADOWS_ANY reads it from the globals.
layout(constant_id = FIRE3DV_VARIANT_SHADOWS) const uint kShadows = FIRE3DV_SHADOWS_ANY;
// False for scenes without textures, without alpha-masked materials, and without uses of the second texture
// coordinates.
layout(constant_id = FIRE3DV_VARIANT_TEXTURES) const bool kTextures = true;
layout(constant_id = FIRE3DV_VARIANT_MASKS) const bool kMasks = true;
layout(constant_id = FIRE3DV_VARIANT_SECOND_UV) const bool kSecondUv = true;
// True for several views in one dispatch, which may show several worlds.
layout(constant_id = FIRE3DV_VARIANT_WORLDS) const bool kSeveralWorlds = false;
// Those of FIRE3DV_MATERIAL_OPTIONAL that a material of the scene has.
layout(constant_id = FIRE3DV_VARIANT_MATERIAL_FLAGS) const uint kMaterialFlags = FIRE3DV_MATERIAL_OPTIONAL;
#ifdef FIRE3DV_CORE_MATERIALS
const bool kAnisotropy = false, kIridescence = false, kDiffuseTransmission = false, kDispersion = false;
#else
const bool kAnisotropy = (kMaterialFlags & FIRE3DV_MATERIAL_ANISOTROPY) != 0;
const bool kIridescence = (kMaterialFlags & FIRE3DV_MATERIAL_IRIDESCENCE) != 0;
const bool kDiffuseTransmission = (kMaterialFlags & FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION) != 0;
const bool kDispersion = (kMaterialFlags & FIRE3DV_MATERIAL_DISPERSION) != 0;
#endif

#endif
