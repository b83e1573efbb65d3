// Fast approximate anti-aliasing after Lottes (2009). It detects edges by luma contrast, follows each edge to
// its ends, and resamples across it. It works on the sRGB-encoded image, whose steps are perceptually
// uniform. Pixels without local contrast keep their exact value. Variant: FIRE3DV_LAYERS.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "visibility/interleaved_groups.glsl"
#include "shared/bindings.h"

#ifdef FIRE3DV_CPU
layout(local_size_x = 8, local_size_y = 1) in;  // each lane processes a column of the tile, see lanes.glsl
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
layout(push_constant, scalar) uniform Push { FxaaPush push; };
#ifdef FIRE3DV_LAYERS
// Several images of one size: a layer each in the source, so that no tap reads a neighbour and all coordinates are
// those of an image alone; stacked vertically in the result.
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2DArray image;
int layer = 0;
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D image;
const int layer = 0;
#endif
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;

const float kMinContrast = 1.0 / 32.0;     // relative to white; lower contrast is invisible
const float kMinRelativeContrast = 0.125;  // relative to the brightest neighbour
const float kSubpixel = 0.75;                // strength of sub-pixel smoothing
const int kSearchSteps = 10;
const float kStepSizes[kSearchSteps] = float[](1, 1, 1, 1, 1.5, 2, 2, 2, 4, 8);

float luma_of(vec3 color) { return dot(color, vec3(0.299, 0.587, 0.114)); }

vec4 fetched(ivec2 pixel) {
#ifdef FIRE3DV_LAYERS
  return texelFetch(image, ivec3(pixel, layer), 0);
#else
  return texelFetch(image, pixel, 0);
#endif
}

vec4 sampled(vec2 uv) {
#ifdef FIRE3DV_LAYERS
  return textureLod(image, vec3(uv, layer), 0);
#else
  return textureLod(image, uv, 0);
#endif
}

void store(ivec2 pixel, vec4 color) { imageStore(result, pixel + ivec2(0, layer * push.height), color); }

vec4 color_at(ivec2 pixel, ivec2 offset) {
  const ivec2 last = ivec2(push.width, push.height) - 1;
  return fetched(clamp(pixel + offset, ivec2(0), last));
}

float luma_at(ivec2 pixel, ivec2 offset) { return luma_of(color_at(pixel, offset).rgb); }

// n, m, s: luma above, at and below the pixel.
vec4 smoothed(ivec2 pixel, vec4 center, float n, float m, float s) {
  const float w = luma_at(pixel, ivec2(-1, 0)), e = luma_at(pixel, ivec2(1, 0));
  const float brightest = max(m, max(max(n, s), max(w, e)));
  const float contrast = brightest - min(m, min(min(n, s), min(w, e)));
  if (contrast < max(kMinContrast, brightest * kMinRelativeContrast)) return center;
  const float nw = luma_at(pixel, ivec2(-1, -1)), ne = luma_at(pixel, ivec2(1, -1));
  const float sw = luma_at(pixel, ivec2(-1, 1)), se = luma_at(pixel, ivec2(1, 1));

  // Edge orientation: second differences across the edge are larger.
  const float change_down = abs(nw + sw - 2 * w) + 2 * abs(n + s - 2 * m) + abs(ne + se - 2 * e);
  const float change_right = abs(nw + ne - 2 * n) + 2 * abs(w + e - 2 * m) + abs(sw + se - 2 * s);
  const bool horizontal = change_down >= change_right;

  // Side of the pixel on which the edge lies.
  const float before = horizontal ? n : w, after = horizontal ? s : e;
  const bool edge_is_before = abs(before - m) >= abs(after - m);
  const float gradient = max(abs(before - m), abs(after - m));
  const float edge_luma = 0.5 * (m + (edge_is_before ? before : after));
  const vec2 texel = 1.0 / vec2(push.width, push.height);
  const vec2 across = (horizontal ? vec2(0, texel.y) : vec2(texel.x, 0)) * (edge_is_before ? -1 : 1);
  const vec2 along = horizontal ? vec2(texel.x, 0) : vec2(0, texel.y);

  // Search along the edge until its luma changes.
  const vec2 uv = (vec2(pixel) + 0.5) * texel;
  const vec2 border = uv + 0.5 * across;
  const float limit = 0.25 * gradient;
  float distance_back = 0, distance_ahead = 0, end_back = 0, end_ahead = 0;
  bool at_back = false, at_ahead = false;
  for (int i = 0; i < kSearchSteps && !(at_back && at_ahead); ++i) {
    if (!at_back) {
      distance_back += kStepSizes[i];
      end_back = luma_of(sampled(border - along * distance_back).rgb) - edge_luma;
      at_back = abs(end_back) >= limit;
    }
    if (!at_ahead) {
      distance_ahead += kStepSizes[i];
      end_ahead = luma_of(sampled(border + along * distance_ahead).rgb) - edge_luma;
      at_ahead = abs(end_ahead) >= limit;
    }
  }
  const float nearest = min(distance_back, distance_ahead);
  const float end_change = distance_back < distance_ahead ? end_back : end_ahead;
  // The true line crosses only a pixel on the far side of the edge from its nearer end.
  const bool crossed = (end_change < 0) != (m - edge_luma < 0);
  const float edge_shift = crossed ? 0.5 - nearest / (distance_back + distance_ahead) : 0;

  // Sub-pixel smoothing of pixels that differ from all neighbours.
  const float around = (2 * (n + s + w + e) + nw + ne + sw + se) / 12;
  const float unlike = smoothstep(0, 1, clamp(abs(around - m) / contrast, 0, 1));
  const float shift = max(edge_shift, unlike * unlike * kSubpixel);
  return sampled(uv + across * shift);
}

#ifdef FIRE3DV_CPU
// The pixel below becomes the lane's next pixel, so its read is reused.
void main() {
#ifdef FIRE3DV_LAYERS
  const uvec3 group = layers_group();
  layer = int(group.z);
#else
  const uvec2 group = image_group();
#endif
  const ivec2 first = ivec2(group.xy * 8) + ivec2(gl_LocalInvocationID.x, 0);
  if (first.x >= push.width) return;
  vec4 center = color_at(first, ivec2(0));
  float n = luma_at(first, ivec2(0, -1)), m = luma_of(center.rgb);
  for (int y = 0; y < min(8, push.height - first.y); ++y) {
    const ivec2 pixel = first + ivec2(0, y);
    const vec4 below = color_at(pixel, ivec2(0, 1));
    const float s = luma_of(below.rgb);
    store(pixel, smoothed(pixel, center, n, m, s));
    center = below;
    n = m;
    m = s;
  }
}
#else
void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
#ifdef FIRE3DV_LAYERS
  layer = int(gl_GlobalInvocationID.z);
#endif
  if (pixel.x >= push.width || pixel.y >= push.height) return;
  const vec4 center = fetched(pixel);
  const float n = luma_at(pixel, ivec2(0, -1)), s = luma_at(pixel, ivec2(0, 1));
  store(pixel, smoothed(pixel, center, n, luma_of(center.rgb), s));
}
#endif
