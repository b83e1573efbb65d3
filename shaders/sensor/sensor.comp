// Image of a camera's sensor: lateral colour, vignette, noise after EMVA 1288, response curve, content mask. The noise
// is a hash of seed, frame, pixel and channel: an image drawn again has the same.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"
#include "common/tone_map.glsl"
#include "path/random.glsl"
#include "sensor/content_mask.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { SensorPush push; };
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;

const uint kFixedPattern = 0x66697865u;
const float kFewElectrons = 24;  // up to so many in the mean, their number is drawn by inversion

// Two numbers of the normal distribution (Box and Muller 1958).
vec2 normal_numbers(vec2 u) {
  const float angle = 6.2831853 * u.y;
  return sqrt(-2 * log(u.x + 1.0 / 33554432.0)) * vec2(cos(angle), sin(angle));
}

// A number of the Poisson distribution, of a uniform and a normal random number.
float poisson_number(float mean, float u, float normal) {
  // Cornish-Fisher expansion, of which the skewness is right.
  if (mean > kFewElectrons) return max(round(mean + sqrt(mean) * normal + (normal * normal - 1) / 6), 0);
  float probability = exp(-mean), sum = probability, count = 0;
  while (sum < u && count < 128) {
    count += 1;
    probability *= mean / count;
    sum += probability;
  }
  return count;
}

// Share of the full well, of exposed light.
vec3 read_out(SensorRecord sensor, uvec2 pixel, vec3 light) {
  const uint place = pixel.y << 16 | pixel.x;
  vec3 read;
  for (uint channel = 0; channel < 3; ++channel) {
    const uint channel_seed = sensor.seed ^ (channel * 0x9e3779b9u);
    const vec4 fixed_numbers = unit_numbers(pcg4d(uvec4(place, kFixedPattern, 0, channel_seed)));
    const vec4 numbers = unit_numbers(pcg4d(uvec4(place, sensor.frame_low, sensor.frame_high, channel_seed)));
    const vec2 pattern = normal_numbers(fixed_numbers.xy), noise = normal_numbers(numbers.xy);
    const float mean = max(light[channel] * sensor.full_well * (1 + sensor.prnu * pattern.x), 0);
    float electrons = poisson_number(min(mean, 2 * sensor.full_well), numbers.z, noise.x);
    electrons += sensor.dark_signal + sensor.dsnu * pattern.y + sensor.read_noise * noise.y;
    read[channel] = clamp(electrons / sensor.full_well, 0, 1);
  }
  return read;
}

void main() {
  const SensorRecord sensor = SensorRecordRef(push.record).value;
  const uvec2 pixel = gl_GlobalInvocationID.xy, size = uvec2(sensor.width, sensor.height);
  if (any(greaterThanEqual(pixel, size))) return;
  const uint64_t source = sensor.fogged != 0ul ? sensor.fogged : sensor.light;
  const vec4 here = light_at(source, pixel.y * size.x + pixel.x);
  vec3 light = here.rgb;
  if (sensor.aberration != 0) {
    const vec2 off = vec2(pixel) + 0.5 - 0.5 * vec2(size);
    light.r = light_between(source, size, 0.5 * vec2(size) + off * (1 - sensor.aberration)).r;
    light.b = light_between(source, size, 0.5 * vec2(size) + off * (1 + sensor.aberration)).b;
  }
  if (sensor.vignette > 0) light *= pow(clamp(here.a, 0, 1), sensor.vignette);
  if (sensor.full_well > 0) light = read_out(sensor, pixel, light);
  vec3 encoded;
  if (sensor.inverse_response > 0) {
    encoded = pow(display_linear(light, 1, (sensor.tone_map & ~0xffu) | FIRE3DV_TONE_MAP_NONE), vec3(sensor.inverse_response));
  } else {
    encoded = encode_srgb(display_linear(light, 1, sensor.tone_map));
  }
  encoded *= mask_coverage(pixel, size, sensor.mask_radius, sensor.mask_cut);
  imageStore(result, ivec2(pixel), vec4(encoded, 1));
}
