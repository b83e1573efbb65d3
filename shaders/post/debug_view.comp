// Debug views: normals, depth, node and cluster colours, overdraw. Blended surfaces, lines and points are not
// included. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_atomic_int64 : require
#include "shading/shown_surface.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { DebugViewPush push; };
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D result;
// low half first
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer CountRef { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer DepthRangeRef { DepthRange value; };

const vec3 kNothing = vec3(0.06);

// Distinct colours for consecutive indices: distant hues, with three alternating tints.
vec3 color_of(uint number) {
  const float hue = fract(float(number % 65536) * 0.61803399 + float(number / 65536) * 0.137);
  const vec3 pure = clamp(abs(fract(hue + vec3(0, 2, 1) / 3) * 6 - 3) - 1, 0, 1);
  const uint kind = number % 3;
  return kind == 0 ? mix(vec3(1), pure, 0.8) * 0.9 : kind == 1 ? mix(vec3(1), pure, 0.55) : pure * 0.6;
}

// Heat colour of overdraw; 1: blue, 4: green, 16 and more: red.
vec3 heat_of(uint count) {
  if (count == 0) return vec3(0);
  const float warm = min(log2(float(count)) / 4, 1);
  return warm < 0.5 ? mix(vec3(0, 0, 1), vec3(0, 1, 0), warm * 2) : mix(vec3(0, 1, 0), vec3(1, 0, 0), warm * 2 - 1);
}

// Logarithmic depth: each doubling of the distance darkens by the same amount.
vec3 brightness_of(float depth_m) {
  const DepthRange range = DepthRangeRef(push.range).value;
  const float nearest = uintBitsToFloat(~range.inverse_nearest), farthest = uintBitsToFloat(range.farthest);
  const float far = farthest > nearest ? log(depth_m / nearest) / log(farthest / nearest) : 0;
  return vec3(mix(1, 0.15, clamp(far, 0, 1)));
}

vec3 shown_color(GlobalsRef globals, ShownSurface shown) {
  if (shown.id == 0) return kNothing;
  if (push.view == FIRE3DV_DEBUG_NORMALS) return normal_of(globals, shown) * 0.5 + 0.5;
  if (push.view == FIRE3DV_DEBUG_DEPTH) return brightness_of(shown.depth_m);
  if (push.view == FIRE3DV_DEBUG_CLUSTERS) return color_of(shown.id >> 7);
  return color_of(UintRef(push.nodes).at[part_of_id(globals, shown.id)]);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  vec3 color;
  if (push.view == FIRE3DV_DEBUG_OVERDRAW) {
    color = heat_of(CountRef(push.counts).at[pixel.y * globals.value.width + pixel.x].x);
  } else {
    const ShownSurface shown = shown_in(globals, Eye(push.visibility, push.look_world, push.orthographic), pixel);
    if (push.view == FIRE3DV_DEBUG_DEPTH_RANGE) {
      if (shown.id == 0 || !(shown.depth_m > 0)) return;
      atomicMax(DepthRangeRef(push.range).value.inverse_nearest, ~floatBitsToUint(shown.depth_m));
      atomicMax(DepthRangeRef(push.range).value.farthest, floatBitsToUint(shown.depth_m));
      return;
    }
    color = shown_color(globals, shown);
  }
  imageStore(result, ivec2(pixel), vec4(color, 1));
}
