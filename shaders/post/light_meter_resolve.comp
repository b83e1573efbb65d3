// Exposure that brings the log-average luminance to middle grey (Reinhard et al. 2002), without the darkest and the
// brightest twentieth of the counted pixels. One workgroup; integer counts make it independent of the order of work.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { LightMeterResolvePush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ExposureOut { float value; };

const uint kBinsOfLane = FIRE3DV_METER_BINS / 256;
const uint kLeftOut = 20;  // a twentieth
const float kMiddleGrey = 0.18;

shared uint counts[256];
shared float stops[256];  // sums of log2 of luminance

void main() {
  const uint lane = gl_LocalInvocationIndex;
  uint own = 0;
  for (uint i = 0; i < kBinsOfLane; ++i) own += UintsRef(push.histogram).at[lane * kBinsOfLane + i];
  counts[lane] = own;
  barrier();
  uint before = 0, total = 0;
  for (uint i = 0; i < 256; ++i) {
    if (i == lane) before = total;
    total += counts[i];
  }
  const uint first = total / kLeftOut, end = total - first;
  float sum = 0;
  for (uint i = 0; i < kBinsOfLane; ++i) {
    const uint bin = lane * kBinsOfLane + i, count = UintsRef(push.histogram).at[bin];
    const uint from = max(before, first), to = min(before + count, end);
    if (to > from) sum += float(to - from) * ((bin + 0.5) / FIRE3DV_METER_BINS_A_STOP + FIRE3DV_METER_DARKEST_STOP);
    before += count;
  }
  stops[lane] = sum;
  barrier();
  if (lane != 0) return;
  float all = 0;
  for (uint i = 0; i < 256; ++i) all += stops[i];
  ExposureOut(push.exposure).value = total == 0 ? push.fallback : kMiddleGrey / exp2(all / float(end - first));
}
