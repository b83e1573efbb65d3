// Exposed light of each pixel in linear colours, the input of the bloom chain. Display-referred colours count as light
// of the brightness that the display shows. Alpha: 1, the weight of a pixel inside of the image. Variants as in
// pixel_light.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "post/exposure.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { BloomLightPush push; };
#include "post/pixel_light.glsl"
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform writeonly image2D result;

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= push.width || pixel.y >= push.height) return;
  const PixelLight light = pixel_light(pixel);
  const vec3 exposed = image_exposure(push.metered, push.exposure) * light.scene_referred + light.display_referred;
  imageStore(result, pixel, vec4(round_to_halves(min(exposed, vec3(kLargestLight))), 1));
}
