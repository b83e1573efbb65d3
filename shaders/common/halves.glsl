// Rounding of 32-bit floats to the nearest half float. Vulkan leaves the rounding of packHalf2x16 and of stores to
// 16-bit images open, and lavapipe truncates, which would darken linear images by up to one part in 1,000. Rounded
// values are exact in both.
#ifndef FIRE3DV_HALVES_GLSL
#define FIRE3DV_HALVES_GLSL

vec3 round_to_halves(vec3 value) {
  const uvec3 bits = floatBitsToUint(value);
  const vec3 normal = uintBitsToFloat((bits + 0xfffu + ((bits >> 13) & 1u)) & ~0x1fffu);
  const vec3 subnormal = roundEven(value * 16777216.0) / 16777216.0;  // multiples of 2^-24
  return mix(normal, subnormal, lessThan(abs(value), vec3(6.103515625e-5)));
}

// Red, green and blue in halves, and one.
uvec2 pack_halves(vec3 value, float last) {
  const vec3 rounded = round_to_halves(value);
  return uvec2(packHalf2x16(rounded.rg), packHalf2x16(vec2(rounded.b, last)));
}

#endif
