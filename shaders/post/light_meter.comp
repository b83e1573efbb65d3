// Histogram of the luminance of an image before exposure, 64 bins a stop. Display-referred and black pixels do not
// count. A workgroup gathers a tile of 64 x 64 pixels. Variants as in pixel_light.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "shared/bindings.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { LightMeterPush push; };
#include "post/pixel_light.glsl"

shared uint bins[FIRE3DV_METER_BINS];

void main() {
  for (uint bin = gl_LocalInvocationIndex; bin < FIRE3DV_METER_BINS; bin += 256) bins[bin] = 0;
  barrier();
  for (uint i = 0; i < 16; ++i) {
    const uvec2 pixel = gl_WorkGroupID.xy * 64 + uvec2(i & 3, i >> 2) * 16 + gl_LocalInvocationID.xy;
    if (pixel.x >= push.width || pixel.y >= push.height) continue;
    const PixelLight light = pixel_light(ivec2(pixel));
    if (light.share < 0.5) continue;
    const float luminance = dot(light.scene_referred / light.share, vec3(0.2126, 0.7152, 0.0722));
    if (!(luminance >= exp2(FIRE3DV_METER_DARKEST_STOP))) continue;
    const float bin = (log2(luminance) - FIRE3DV_METER_DARKEST_STOP) * FIRE3DV_METER_BINS_A_STOP;
    atomicAdd(bins[uint(clamp(bin, 0, FIRE3DV_METER_BINS - 1))], 1);
  }
  barrier();
  for (uint bin = gl_LocalInvocationIndex; bin < FIRE3DV_METER_BINS; bin += 256) {
    if (bins[bin] != 0) atomicAdd(UintsRef(push.histogram).at[bin], bins[bin]);
  }
}
