// Exposed light of each pixel before the camera's optics, in linear colours, with bloom. Display-referred colours
// count as light of the brightness that the display shows. Variants as in pixel_light.glsl, and FIRE3DV_BLOOM.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "sensor/sensor.glsl"
#include "post/exposure.glsl"
#ifdef FIRE3DV_BLOOM
#include "post/bloom.glsl"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { SensorPush pushed; };
#define push SensorRecordRef(pushed.record).value
#include "post/pixel_light.glsl"
#ifdef FIRE3DV_BLOOM
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_BLOOM) uniform sampler2D first_level;
#endif

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy, size = uvec2(push.width, push.height);
  if (any(greaterThanEqual(pixel, size))) return;
  const PixelLight light = pixel_light(ivec2(pixel));
  vec3 exposed = image_exposure(push.metered, push.exposure) * light.scene_referred + light.display_referred;
#ifdef FIRE3DV_BLOOM
  exposed = mix(exposed, blurred_light(first_level, ivec2(pixel)), push.bloom);
#endif
  const vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2 - 1;
  const vec3 ray = push.ray_x * ndc.x + push.ray_y * ndc.y + push.ray_origin;
  LightRef4(push.light).at[pixel.y * size.x + pixel.x] = pack_light(exposed, dot(normalize(ray), push.axis));
}
