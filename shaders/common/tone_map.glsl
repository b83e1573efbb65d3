// From linear HDR to what a display takes.
#ifndef FIRE3DV_TONE_MAP_GLSL
#define FIRE3DV_TONE_MAP_GLSL

// Reinhard et al. 2002, per channel.
vec3 tone_map_reinhard(vec3 color) { return color / (1 + color); }

// IEC 61966-2-1.
vec3 encode_srgb(vec3 linear) {
  const vec3 low = linear * 12.92;
  const vec3 high = 1.055 * pow(linear, vec3(1 / 2.4)) - 0.055;
  return mix(high, low, lessThanEqual(linear, vec3(0.0031308)));
}

#endif
