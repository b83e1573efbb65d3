// Colour of an image marker, display-referred like marker.frag: bilinear, and where texels are smaller than pixels
// the mean of several samples of the pixel's footprint. Interpolates in linear light, premultiplied.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "markers/marker_output.glsl"

layout(location = 1) in vec2 in_texel;

const int kMaxTaps = 4;  // along each axis of the footprint

vec4 texel_at(ivec2 texel) {
  const uvec2 at = min(uvec2(max(texel, ivec2(0))), uvec2(push.segments, push.rings) - 1);
  const uint index = at.y * push.segments + at.x;
  const vec4 srgb = unpackUnorm4x8(UintRef(push.colors).at[index]);
  const vec3 low = srgb.rgb / 12.92, high = pow((srgb.rgb + 0.055) / 1.055, vec3(2.4));
  return vec4(mix(high, low, lessThanEqual(srgb.rgb, vec3(0.04045))) * srgb.a, srgb.a);
}

// Coordinates count from the corner of the first texel. Edges repeat.
vec4 bilinear(vec2 texel) {
  const vec2 last = vec2(push.segments, push.rings) - 1;
  const vec2 at = clamp(texel - 0.5, vec2(0), last);
  const ivec2 low = ivec2(at), high = min(low + 1, ivec2(last));
  const vec2 share = at - vec2(low);
  return mix(mix(texel_at(low), texel_at(ivec2(high.x, low.y)), share.x),
             mix(texel_at(ivec2(low.x, high.y)), texel_at(high), share.x), share.y);
}

void main() {
  const bool is_shown = begin_marker(15);
  // Near the horizon of a large quad, extrapolated coordinates may be infinite.
  vec2 along = dFdx(in_texel), down = dFdy(in_texel);
  const bool is_finite = !any(isnan(in_texel)) && !any(isinf(in_texel));
  const vec2 middle = is_finite ? in_texel : vec2(0);
  if (any(isnan(along)) || any(isinf(along))) along = vec2(0);
  if (any(isnan(down)) || any(isinf(down))) down = vec2(0);
  const int columns = int(clamp(ceil(length(along) - 0.01), 1, float(kMaxTaps)));
  const int rows = int(clamp(ceil(length(down) - 0.01), 1, float(kMaxTaps)));
  vec4 sum = vec4(0);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      sum += bilinear(middle + along * ((column + 0.5) / columns - 0.5) + down * ((row + 0.5) / rows - 0.5));
  if (!is_shown) discard;  // fragments without colour draw it, since a layer may wait for it
  draw_marker(is_finite ? sum / (rows * columns) : vec4(0));
}
