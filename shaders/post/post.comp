// Exposure, tone mapping and sRGB encoding. Samples are tone-mapped before the average, since averages of HDR
// values leave bright edges jagged. The linear output averages the radiance itself, without bloom; it includes
// the pixels that shading has tone-mapped from unrounded radiance. Variants: FIRE3DV_MULTISAMPLED, FIRE3DV_BLOOM.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "common/tone_map.glsl"
#ifdef FIRE3DV_BLOOM
#include "post/bloom.glsl"
#endif
#include "post/exposure.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PostPush push; };
#ifdef FIRE3DV_MULTISAMPLED
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2DMS hdr;
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D hdr;
#endif
#ifdef FIRE3DV_BLOOM
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_BLOOM) uniform sampler2D first_level;
#endif
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer HalfsOut { uvec2 at[]; };

const float kLargestHalf = 65504;

void tone_map(ivec2 pixel) {
  const float exposure = image_exposure(push.metered, push.exposure);
#ifdef FIRE3DV_BLOOM
  const vec3 blurred = blurred_light(first_level, pixel);
#endif
  vec3 sum = vec3(0);
  // The alpha is the share of scene-referred light; the rest is display-referred.
  for (int i = 0; i < push.samples; ++i) {
    const vec4 color = texelFetch(hdr, pixel, i);
#ifdef FIRE3DV_BLOOM
    const vec3 exposed = mix(max(color.rgb * exposure, vec3(0)), blurred, push.bloom);
    const vec3 shown = mix(clamp(color.rgb, vec3(0), vec3(1)), blurred, push.bloom);
    sum += mix(clamp(shown, vec3(0), vec3(1)), display_linear(exposed, 1, push.tone_map), clamp(color.a, 0, 1));
#else
    sum += mix(clamp(color.rgb, vec3(0), vec3(1)), display_linear(color.rgb, exposure, push.tone_map), clamp(color.a, 0, 1));
#endif
  }
  imageStore(result, pixel, vec4(encode_srgb(sum / push.samples), 1));
}

void main() {
  const bool is_whole = push.linear != 0ul;
  const uvec2 first = uvec2(push.first_x, push.first_y), end = uvec2(push.end_x, push.end_y);
  const uvec2 pixel = gl_GlobalInvocationID.xy + (is_whole ? uvec2(0) : first);
  if (any(greaterThanEqual(pixel, is_whole ? uvec2(push.width, push.height) : end))) return;
  if (all(greaterThanEqual(pixel, first)) && all(lessThan(pixel, end))) tone_map(ivec2(pixel));
  if (!is_whole) return;
  vec3 light = vec3(0);
  for (int i = 0; i < push.samples; ++i) light += texelFetch(hdr, ivec2(pixel), i).rgb;
  light = min(light / push.samples, vec3(kLargestHalf));
  HalfsOut(push.linear).at[pixel.y * push.width + pixel.x] = pack_halves(light, 1);
}
