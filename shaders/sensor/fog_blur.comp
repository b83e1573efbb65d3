// Gaussian blur of the blocks of a fogged image, along rows, then along columns. The image is mirrored at its edges,
// so that no light is lost there.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { SensorPush push; };

int mirrored(int i, int count) {
  const int period = 2 * count, within = (i % period + period) % period;
  return within < count ? within : period - 1 - within;
}

void main() {
  const SensorRecord sensor = SensorRecordRef(push.record).value;
  const ivec2 cell = ivec2(gl_GlobalInvocationID.xy), size = ivec2(sensor.grid_width, sensor.grid_height);
  if (any(greaterThanEqual(cell, size))) return;
  const int cells = size.x * size.y, radius = int(ceil(3 * sensor.blur_cells));
  const int from = push.along_rows != 0 ? 0 : cells;
  vec3 sum = vec3(0);
  float weights = 0;
  for (int i = -radius; i <= radius; ++i) {
    const float weight = exp(-0.5 * i * i / (sensor.blur_cells * sensor.blur_cells));
    const ivec2 at = push.along_rows != 0 ? ivec2(mirrored(cell.x + i, size.x), cell.y) : ivec2(cell.x, mirrored(cell.y + i, size.y));
    sum += weight * CellRef(sensor.grid).at[from + at.y * size.x + at.x].rgb;
    weights += weight;
  }
  CellRef(sensor.grid).at[from + cells + cell.y * size.x + cell.x] = vec4(sum / weights, 0);
}
