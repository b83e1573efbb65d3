// Stale overlay on a finished image whose stream sends no frames: a striped border, and a badge in the upper
// right corner. Two bars mean late, a cross means lost. Amber and red alternate with black for contrast on
// any background, also for colour-blind viewers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { StaleOverlayPush push; };
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;

const vec4 kAmber = vec4(1, 0.69, 0, 1), kRed = vec4(0.9, 0.1, 0.1, 1), kBlack = vec4(0, 0, 0, 1);

// Shape of the badge's symbol, in units of its radius from its centre.
bool in_symbol(vec2 at) {
  if (push.condition == FIRE3DV_STALE_LATE) return abs(at.y) < 0.5 && abs(abs(at.x) - 0.28) < 0.14;
  return min(abs(at.x - at.y), abs(at.x + at.y)) < 0.22 && max(abs(at.x), abs(at.y)) < 0.5;
}

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  const ivec2 size = ivec2(push.width, push.height);
  if (any(greaterThanEqual(pixel, size))) return;
  const int shorter = min(size.x, size.y);
  const vec4 color = push.condition == FIRE3DV_STALE_LATE ? kAmber : kRed;

  const int thick = max(shorter / 90, 2);
  const ivec2 to_edge = min(pixel, size - 1 - pixel);
  if (min(to_edge.x, to_edge.y) < thick) {
    imageStore(result, pixel, (pixel.x + pixel.y) / (3 * thick) % 2 == 0 ? color : kBlack);
    return;
  }
  const float radius = max(shorter * 0.05, 7.0);
  const vec2 center = vec2(size.x - 2 * thick - radius, 2 * thick + radius);
  const vec2 at = (vec2(pixel) + 0.5 - center) / radius;
  const float away = length(at);
  if (away >= 1) return;
  imageStore(result, pixel, in_symbol(at) || away > 0.85 ? color : kBlack);
}
