// Common bindings and parameters of the environment preprocessing shaders.
#ifndef FIRE3DV_ENVIRONMENT_PASS_GLSL
#define FIRE3DV_ENVIRONMENT_PASS_GLSL
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/bindings.h"
#include "shared/types.h"
#include "common/directions.glsl"
#include "common/shared_exponent.glsl"

layout(push_constant, scalar) uniform Push { EnvironmentPush push; };
layout(local_size_x = 8, local_size_y = 8) in;

// FIRE3DV_PACKED_RADIANCE writes shared-exponent radiance; other outputs have four half floats.
#ifdef FIRE3DV_PACKED_RADIANCE
layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_OUT, r32ui) uniform writeonly uimage2DArray level_out;

void put_radiance(ivec3 texel, vec3 radiance) { imageStore(level_out, texel, uvec4(pack_rgb9e5(radiance))); }
#else
layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_OUT, rgba16f) uniform writeonly image2DArray level_out;
#endif

#endif
