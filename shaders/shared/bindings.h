// Descriptor bindings and specialisation constants, shared by C++ and GLSL.
#ifndef FIRE3DV_SHARED_BINDINGS_H
#define FIRE3DV_SHARED_BINDINGS_H

// specialisation constants, see common/scene_variant.glsl
#define FIRE3DV_VARIANT_SHADOWS 0
#define FIRE3DV_VARIANT_TEXTURES 1
#define FIRE3DV_VARIANT_MASKS 2
#define FIRE3DV_VARIANT_SECOND_UV 3
#define FIRE3DV_VARIANT_MATERIAL_FLAGS 4
#define FIRE3DV_VARIANT_WORLDS 5
#define FIRE3DV_VARIANT_COUNT 6

// set 0: the scene
#define FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND 0
#define FIRE3DV_BINDING_ENVIRONMENT_SPECULAR 1
#define FIRE3DV_BINDING_ENVIRONMENT_IRRADIANCE 2
#define FIRE3DV_BINDING_ENVIRONMENT_ALBEDO 3
#define FIRE3DV_ENVIRONMENT_ALBEDO_SIDE 64  // texels a side of its table
#define FIRE3DV_BINDING_TEXTURES 4          // last, since its count varies

// set 0 of image filters
#define FIRE3DV_BINDING_FILTER_IN 0
#define FIRE3DV_BINDING_FILTER_OUT 1
#define FIRE3DV_BINDING_FILTER_BLOOM 2  // first level of the bloom chain

// set 1: images of a frame
#define FIRE3DV_BINDING_DISPLAY 0
#define FIRE3DV_BINDING_HDR 1
// set 0 of environment preprocessing
#define FIRE3DV_BINDING_LEVEL_IN 0  // all levels, through a sampler
#define FIRE3DV_BINDING_LEVEL_OUT 1
#define FIRE3DV_BINDING_LEVEL_ABOVE 2  // one level, texel by texel

#endif
