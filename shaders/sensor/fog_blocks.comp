// Mean light of blocks of pixels, the coarse image that fog is blurred in. One workgroup a block; sums are taken in
// a fixed order, so that all devices with the same arithmetic have the same bytes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SensorPush push; };

shared vec3 sums[64];

void main() {
  const SensorRecord sensor = SensorRecordRef(push.record).value;
  const uvec2 low = gl_WorkGroupID.xy * sensor.block, high = min(low + sensor.block, uvec2(sensor.width, sensor.height));
  const uvec2 size = high - low;
  const uint count = size.x * size.y;
  vec3 sum = vec3(0);
  for (uint i = gl_LocalInvocationIndex; i < count; i += 64)
    sum += light_at(sensor.light, (low.y + i / size.x) * sensor.width + low.x + i % size.x).rgb;
  sums[gl_LocalInvocationIndex] = sum;
  barrier();
  for (uint half_count = 32; half_count > 0; half_count /= 2) {
    if (gl_LocalInvocationIndex < half_count) sums[gl_LocalInvocationIndex] += sums[gl_LocalInvocationIndex + half_count];
    barrier();
  }
  if (gl_LocalInvocationIndex == 0)
    CellRef(sensor.grid).at[gl_WorkGroupID.y * sensor.grid_width + gl_WorkGroupID.x] = vec4(sums[0] / float(count), float(count));
}
