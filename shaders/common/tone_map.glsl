// Tone mapping operators and sRGB encoding.
#ifndef FIRE3DV_TONE_MAP_GLSL
#define FIRE3DV_TONE_MAP_GLSL

// Reinhard et al. 2002, per channel.
vec3 tone_map_reinhard(vec3 color) { return color / (1 + color); }

// ACES reference and output transforms for sRGB, as fitted by Hill (2016): into a wider space, a rational
// curve, back.
vec3 tone_map_aces(vec3 color) {
  const mat3 in_from_srgb = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
  const mat3 srgb_from_out = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
  const vec3 v = in_from_srgb * color;
  const vec3 curve = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
  return clamp(srgb_from_out * curve, 0, 1);
}

// Khronos PBR Neutral (specification of 2024): keeps colours below the shoulder; compresses and desaturates
// the others.
vec3 tone_map_neutral(vec3 color) {
  const float start = 0.8 - 0.04, desaturation = 0.15;
  const float least = min(color.r, min(color.g, color.b));
  const float offset = least < 0.08 ? least - 6.25 * least * least : 0.04;
  color -= offset;
  const float peak = max(color.r, max(color.g, color.b));
  if (peak < start) return color;
  const float d = 1 - start;
  const float new_peak = 1 - d * d / (peak + d - start);
  color *= new_peak / peak;
  const float g = 1 - 1 / (desaturation * (peak - new_peak) + 1);
  return mix(color, vec3(new_peak), g);
}

// IEC 61966-2-1.
vec3 encode_srgb(vec3 linear) {
  const vec3 low = linear * 12.92;
  const vec3 high = 1.055 * pow(linear, vec3(1 / 2.4)) - 0.055;
  return mix(high, low, lessThanEqual(linear, vec3(0.0031308)));
}

vec3 apply_tone_map(vec3 color, uint curve) {
  switch (curve) {
    case FIRE3DV_TONE_MAP_REINHARD: return tone_map_reinhard(color);
    case FIRE3DV_TONE_MAP_ACES: return tone_map_aces(color);
    case FIRE3DV_TONE_MAP_NEUTRAL: return tone_map_neutral(color);
  }
  return min(color, vec3(1));
}

// Display-linear colour after exposure, tone mapping and saturation, 0 to 1. tone_map: FIRE3DV_TONE_MAP_* in the low
// byte; above it the saturation in steps of 1/1024, plus one. 0: unchanged.
vec3 display_linear(vec3 color, float exposure, uint tone_map) {
  const vec3 shown = apply_tone_map(clamp(color * exposure, vec3(0), vec3(65504)), tone_map & 0xffu);
  const uint saturation = tone_map >> 8;
  if (saturation == 0u) return shown;
  const float luminance = dot(shown, vec3(0.2126, 0.7152, 0.0722));
  return clamp(mix(vec3(luminance), shown, float(saturation - 1u) / 1024), 0, 1);
}

// Display-referred colours (unlit materials, plain backgrounds) are shown as they are.
vec3 display_linear(vec3 color, bool is_display_referred, float exposure, uint tone_map) {
  return is_display_referred ? clamp(color, vec3(0), vec3(1)) : display_linear(color, exposure, tone_map);
}

#endif
