// Common bindings and parameters of the environment preprocessing shaders.
#ifndef FIRE3DV_ENVIRONMENT_PASS_GLSL
#define FIRE3DV_ENVIRONMENT_PASS_GLSL
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/bindings.h"
#include "shared/types.h"
#include "common/directions.glsl"

layout(push_constant, scalar) uniform Push { EnvironmentPush push; };
layout(local_size_x = 8, local_size_y = 8) in;

// FIRE3DV_PACKED_RADIANCE writes shared-exponent radiance; other outputs have four half floats.
#ifdef FIRE3DV_PACKED_RADIANCE
layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_OUT, r32ui) uniform writeonly uimage2DArray level_out;

// VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, identical to scene::pack_rgb9e5().
uint packed_radiance(vec3 radiance) {
  const int kBias = 15, kMantissaBits = 9;
  const vec3 color = clamp(radiance, vec3(0), vec3(65408));
  const float largest = max(color.r, max(color.g, color.b));
  int exponent = max(int(floatBitsToUint(largest) >> 23) - 127, -kBias - 1) + 1 + kBias;
  float texel_step = uintBitsToFloat(uint(exponent - kBias - kMantissaBits + 127) << 23);
  if (floor(largest / texel_step + 0.5) == 1 << kMantissaBits) {  // rounds up to one bit more
    texel_step *= 2;
    ++exponent;
  }
  const uvec3 mantissa = uvec3(floor(color / texel_step + 0.5));
  return mantissa.r | mantissa.g << 9 | mantissa.b << 18 | uint(exponent) << 27;
}

void put_radiance(ivec3 texel, vec3 radiance) { imageStore(level_out, texel, uvec4(packed_radiance(radiance))); }
#else
layout(set = 0, binding = FIRE3DV_BINDING_LEVEL_OUT, rgba16f) uniform writeonly image2DArray level_out;
#endif

#endif
