// Debug view of unresolved pixels: greys the image, then marks pixels whose shadow maps were inconclusive.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "shared/bindings.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { UnresolvedPixelsPush push; };
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform image2D result;

const vec4 kUnresolvedColor = vec4(1, 0.6, 0, 1);

void main() {
  const uint index = gl_GlobalInvocationID.x + gl_WorkGroupID.y * 65535 * 64;
  if (push.marks == 0) {
    if (index >= push.width * push.height) return;
    const ivec2 pixel = ivec2(index % push.width, index / push.width);
    imageStore(result, pixel, vec4(vec3(dot(imageLoad(result, pixel).rgb, vec3(0.21, 0.72, 0.07)) * 0.5), 1));
    return;
  }
  if (index >= RayListRef(push.lists).at[FIRE3DV_LIST_PIXELS].width) return;
  const uint pixel = RayEntryRef(push.entries).at[index].pixel;
  imageStore(result, ivec2(pixel % push.width, pixel / push.width), kUnresolvedColor);
}
