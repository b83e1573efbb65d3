// Empties the pixels of a plane that a content mask covers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "sensor/content_mask.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { MaskPlanesPush push; };

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy, size = uvec2(push.width, push.height);
  if (any(greaterThanEqual(pixel, size)) || is_in_mask(pixel, size, push.mask_radius, push.mask_cut)) return;
  const uint first = (pixel.y * size.x + pixel.x) * push.words;
  for (uint i = 0; i < push.words; ++i)
    WordRef(push.plane).at[first + i] = i + 1 == push.words ? push.last : i == 0 ? push.first : push.others;
}
