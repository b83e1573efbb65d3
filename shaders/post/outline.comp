// Outline of selected nodes: two pixels of orange, with a dark rim for contrast on bright images. Selected
// surfaces keep their appearance. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"
#include "shared/bindings.h"

const int kSide = 8, kReach = 3, kTileSide = kSide + 2 * kReach;
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { OutlinePush push; };
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform image2D result;

shared float shares[kTileSide * kTileSide];

const vec3 kLine = vec3(1, 0.55, 0.05);
const float kLineReach = 2.5, kRimReach = 3.5;

// Share of a pixel's samples that show selected nodes.
float share_of(GlobalsRef globals, ivec2 pixel) {
  const ivec2 last = ivec2(globals.value.width, globals.value.height) - 1;
  const uvec2 at = uvec2(clamp(pixel, ivec2(0), last));  // clamped: surfaces cut by the image border get no
                                                         // line there
  const PixelIds ids = pixel_ids(globals, push.visibility, at.y * globals.value.width + at.x);
  float count = 0;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    const uint id = id_of_sample(ids, s);
    if (id == 0) continue;
    const uint part = part_of_id(globals, id);
    count += float(UintRef(push.selected).at[part >> 5] >> (part & 31) & 1);
  }
  return count / FIRE3DV_SAMPLES;
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const ivec2 first = ivec2(gl_WorkGroupID.xy) * kSide - kReach;
  for (uint i = gl_LocalInvocationIndex; i < kTileSide * kTileSide; i += kSide * kSide)
    shares[i] = share_of(globals, first + ivec2(i % kTileSide, i / kTileSide));
  barrier();
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), local = ivec2(gl_LocalInvocationID.xy) + kReach;
  if (any(greaterThanEqual(pixel, ivec2(globals.value.width, globals.value.height)))) return;
  float line = 0, rim = 0;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      const float share = shares[(local.y + y) * kTileSide + local.x + x], away = length(vec2(x, y));
      line = max(line, share * clamp(kLineReach - away, 0, 1));
      rim = max(rim, share * clamp(kRimReach - away, 0, 1));
    }
  }
  const float around = 1 - shares[local.y * kTileSide + local.x];
  if (around * rim == 0) return;
  vec3 color = imageLoad(result, pixel).rgb;
  color = mix(color, vec3(0), 0.6 * rim * around);
  imageStore(result, pixel, vec4(mix(color, kLine, line * around), 1));
}
