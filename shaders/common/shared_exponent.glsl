// Radiance with an exponent that three mantissas share, in 32 bits.
#ifndef FIRE3DV_SHARED_EXPONENT_GLSL
#define FIRE3DV_SHARED_EXPONENT_GLSL

// VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, identical to scene::pack_rgb9e5().
uint pack_rgb9e5(vec3 radiance) {
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

vec3 unpack_rgb9e5(uint packed) {
  const uvec3 mantissa = uvec3(packed, packed >> 9, packed >> 18) & 0x1ffu;
  return vec3(mantissa) * uintBitsToFloat(((packed >> 27) + 127 - 15 - 9) << 23);
}

#endif
