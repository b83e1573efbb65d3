// Exposure, tone mapping and sRGB encoding. Samples are tone-mapped before they are averaged: averaging HDR values first
// leaves bright edges jagged. Variant: FIRE3DV_MULTISAMPLED.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/tone_map.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PostPush push; };
#ifdef FIRE3DV_MULTISAMPLED
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2DMS hdr;
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D hdr;
#endif
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;

vec3 display_linear(vec3 color) {
  color = clamp(color * push.exposure, vec3(0), vec3(65504));
  switch (push.tone_map) {
    case FIRE3DV_TONE_MAP_REINHARD: return tone_map_reinhard(color);
    case FIRE3DV_TONE_MAP_ACES: return tone_map_aces(color);
    case FIRE3DV_TONE_MAP_NEUTRAL: return tone_map_neutral(color);
  }
  return min(color, vec3(1));
}

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= push.width || pixel.y >= push.height) return;
  vec3 sum = vec3(0);
  for (int i = 0; i < push.samples; ++i) sum += display_linear(texelFetch(hdr, pixel, i).rgb);
  imageStore(result, pixel, vec4(encode_srgb(sum / push.samples), 1));
}
