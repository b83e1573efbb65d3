// Mean light of an image, and its ratio to the mean of the blurred blocks, by which fog keeps it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { SensorPush push; };

shared vec3 exact[256], blurred[256];

void main() {
  const SensorRecord sensor = SensorRecordRef(push.record).value;
  const uint cells = sensor.grid_width * sensor.grid_height, thread = gl_LocalInvocationIndex;
  vec3 sum = vec3(0), sum_blurred = vec3(0);
  for (uint i = thread; i < cells; i += 256) {
    const vec4 block = CellRef(sensor.grid).at[i];
    sum += block.rgb * block.a;
    sum_blurred += CellRef(sensor.grid).at[2 * cells + i].rgb * block.a;
  }
  exact[thread] = sum;
  blurred[thread] = sum_blurred;
  barrier();
  for (uint half_count = 128; half_count > 0; half_count /= 2) {
    if (thread < half_count) {
      exact[thread] += exact[thread + half_count];
      blurred[thread] += blurred[thread + half_count];
    }
    barrier();
  }
  if (thread != 0) return;
  CellRef(sensor.means).at[0] = vec4(exact[0] / (float(sensor.width) * sensor.height), 0);
  CellRef(sensor.means).at[1] = vec4(mix(vec3(1), exact[0] / max(blurred[0], vec3(1e-30)), greaterThan(blurred[0], vec3(0))), 0);
}
