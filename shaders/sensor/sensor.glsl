// Buffers of a camera's optics and sensor.
#ifndef FIRE3DV_SENSOR_GLSL
#define FIRE3DV_SENSOR_GLSL
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "shared/bindings.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SensorRecordRef { SensorRecord value; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LightRef4 { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer CellRef { vec4 at[]; };

uvec2 pack_light(vec3 light, float cosine) {
  return pack_halves(min(light, vec3(65504)), round_to_halves(vec3(cosine)).x);
}

// Exposed light, and the cosine of the angle off the axis.
vec4 light_at(uint64_t light, uint index) {
  const uvec2 halves = LightRef4(light).at[index];
  return vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
}

// Bilinear, clamped to the edge. place: in pixels, whose centres are at 0.5.
vec3 light_between(uint64_t light, uvec2 size, vec2 place) {
  const vec2 from = clamp(place - 0.5, vec2(0), vec2(size - 1u));
  const uvec2 low = uvec2(from), high = min(low + 1u, size - 1u);
  const vec2 f = from - vec2(low);
  const uvec2 row = uvec2(low.y, high.y) * size.x;
  const vec3 upper = mix(light_at(light, row.x + low.x).rgb, light_at(light, row.x + high.x).rgb, f.x);
  const vec3 lower = mix(light_at(light, row.y + low.x).rgb, light_at(light, row.y + high.x).rgb, f.x);
  return mix(upper, lower, f.y);
}

#endif
