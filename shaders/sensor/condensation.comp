// Light behind a window with condensation: fog, which blurs a share of the light and spreads another one over the
// image, and drops, spherical caps of water, through which one sees another place of the image.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"
#include "path/random.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { SensorPush push; };

const float kWater = 1.33;                 // index of refraction
const float kSineOfContact = 0.70710678;   // of the angle between water and window at the edge of a drop
const float kSmallestDrop = 0.4;           // over the largest; radii are even between
// Mean area of a drop over that of its cell, as wide as the largest drop: pi / 4 (1 - 0.4^3) / (3 (1 - 0.4)).
const float kAreaOfDrops = 0.40841;

// Blurred light between the blocks' centres.
vec3 fogged_light(SensorRecord sensor, uvec2 pixel) {
  const uvec2 last = uvec2(sensor.grid_width, sensor.grid_height) - 1u;
  const vec2 from = clamp((vec2(pixel) + 0.5) / sensor.block - 0.5, vec2(0), vec2(last));
  const uvec2 low = uvec2(from), high = min(low + 1u, last);
  const vec2 f = from - vec2(low);
  const uint first = 2 * sensor.grid_width * sensor.grid_height;
  const uvec2 row = first + uvec2(low.y, high.y) * sensor.grid_width;
  const vec3 upper = mix(CellRef(sensor.grid).at[row.x + low.x].rgb, CellRef(sensor.grid).at[row.x + high.x].rgb, f.x);
  const vec3 lower = mix(CellRef(sensor.grid).at[row.y + low.x].rgb, CellRef(sensor.grid).at[row.y + high.x].rgb, f.x);
  return mix(upper, lower, f.y) * CellRef(sensor.means).at[1].rgb;
}

void main() {
  const SensorRecord sensor = SensorRecordRef(push.record).value;
  const uvec2 pixel = gl_GlobalInvocationID.xy, size = uvec2(sensor.width, sensor.height);
  if (any(greaterThanEqual(pixel, size))) return;
  const uint index = pixel.y * size.x + pixel.x;
  const vec4 clear = light_at(sensor.light, index);
  vec3 seen = clear.rgb;
  if (sensor.fog > 0) {
    const vec3 fogged = mix(fogged_light(sensor, pixel), CellRef(sensor.means).at[0].rgb, sensor.fog_veil);
    seen = mix(seen, fogged, sensor.fog);
  }
  if (sensor.drops > 0) {
    // One cell of a drop; rows are shifted against each other.
    vec2 place = (vec2(pixel) + 0.5) / sensor.drop_px;
    const uint row = uint(place.y);
    const float shift = unit_numbers(pcg4d(uvec4(row, 1, 0x64726f70u, sensor.seed))).x;
    place.x += shift;
    const uint column = uint(place.x);
    const vec4 u = unit_numbers(pcg4d(uvec4(column, row, 0x64726f70u, sensor.seed)));
    const float radius = 0.5 * mix(kSmallestDrop, 1, u.y);  // in cells
    const vec2 centre = vec2(column, row) + radius + u.zw * (1 - 2 * radius);
    const vec2 off = (place - centre) / radius;
    const float rho = length(off);
    if (u.x < sensor.drops / kAreaOfDrops && rho < 1 && rho > 0) {
      // A ray along the axis meets the cap at the angle `slope` and leaves it bent towards the drop's middle.
      const float slope = asin(rho * kSineOfContact);
      const float bent = asin(min(kWater * sin(slope), 1)) - slope;
      const vec2 from = vec2(pixel) + 0.5 - off / rho * tan(bent) * sensor.focal_px;
      const vec3 through = light_between(sensor.light, size, from);
      seen = mix(seen, through, 1 - smoothstep(0.75, 1, rho));  // far out of focus
    }
  }
  LightRef4(sensor.fogged).at[index] = pack_light(seen, clear.a);
}
