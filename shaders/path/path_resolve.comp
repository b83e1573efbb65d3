// Image of path-traced sums: mean, exposure, tone mapping and sRGB encoding. The mean precedes tone mapping, since
// single samples are noisy; scene-referred and display-referred samples of an edge pixel are averaged on the display,
// as in post.comp. Variant: FIRE3DV_BLOOM.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "common/tone_map.glsl"
#ifdef FIRE3DV_BLOOM
#include "post/bloom.glsl"
#endif
#include "post/exposure.glsl"
#include "shared/bindings.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PathResolvePush push; };
#ifdef FIRE3DV_BLOOM
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_BLOOM) uniform sampler2D first_level;
#endif
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba8) uniform writeonly image2D result;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer PathSumRef { PathSum at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer HalfsOut { uvec2 at[]; };

void main() {
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= push.width || pixel.y >= push.height) return;
  const uint index = pixel.y * push.width + pixel.x;
  const PathSum sum = PathSumRef(push.sums).at[index];
  const vec3 radiance = sum.radiance / max(sum.radiance_samples, 1);
  const float samples = max(sum.samples, 1), share = sum.radiance_samples / samples;
  const float exposure = image_exposure(push.metered, push.exposure);
#ifdef FIRE3DV_BLOOM
  const vec3 blurred = blurred_light(first_level, ivec2(pixel));
  const vec3 display = mix(sum.display / samples, (1 - share) * blurred, push.bloom);
  const vec3 shown = display_linear(mix(radiance * exposure, blurred, push.bloom), 1, push.tone_map) * share + display;
#else
  const vec3 shown = display_linear(radiance, exposure, push.tone_map) * share + sum.display / samples;
#endif
  imageStore(result, ivec2(pixel), vec4(encode_srgb(clamp(shown, vec3(0), vec3(1))), 1));
  if (push.linear == 0ul) return;
  HalfsOut(push.linear).at[index] = pack_halves(min((sum.radiance + sum.display) / samples, vec3(65504)), 1);
}
