// What the shaders that prepare the surroundings share: their images and their numbers.
#ifndef FIRE3DV_ENVIRONMENT_PASS_GLSL
#define FIRE3DV_ENVIRONMENT_PASS_GLSL
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/bindings.h"
#include "shared/types.h"
#include "common/directions.glsl"

layout(push_constant, scalar) uniform Push { EnvironmentPush push; };
layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_OUT, rgba16f) uniform writeonly image2DArray level_out;
layout(local_size_x = 8, local_size_y = 8) in;

#endif
