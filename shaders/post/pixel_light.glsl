// Light of one pixel before exposure: the mean of its samples, from the HDR target or from path-traced sums.
// The including shader has a push constant `push` with `samples`; for FIRE3DV_PATH_SUMS with `sums` and `width`.
// Variants: FIRE3DV_MULTISAMPLED, FIRE3DV_PATH_SUMS.
#ifndef FIRE3DV_PIXEL_LIGHT_GLSL
#define FIRE3DV_PIXEL_LIGHT_GLSL

struct PixelLight {
  vec3 scene_referred;  // radiance times its share
  float share;          // of scene-referred light
  vec3 display_referred;
};

const float kLargestLight = 65504;  // of half floats

#ifdef FIRE3DV_PATH_SUMS
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer PathSumRef { PathSum at[]; };
#elif defined(FIRE3DV_MULTISAMPLED)
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2DMS hdr;
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_IN) uniform sampler2D hdr;
#endif

PixelLight pixel_light(ivec2 pixel) {
  PixelLight light;
#ifdef FIRE3DV_PATH_SUMS
  const PathSum sum = PathSumRef(push.sums).at[pixel.y * push.width + pixel.x];
  const float samples = max(sum.samples, 1);
  light = PixelLight(sum.radiance, sum.radiance_samples, sum.display);
#else
  const float samples = push.samples;
  light = PixelLight(vec3(0), 0, vec3(0));
  for (int i = 0; i < push.samples; ++i) {
    const vec4 color = texelFetch(hdr, pixel, i);
    const float share = clamp(color.a, 0, 1);
    light.scene_referred += share * max(color.rgb, vec3(0));
    light.share += share;
    light.display_referred += (1 - share) * clamp(color.rgb, vec3(0), vec3(1));
  }
#endif
  light.scene_referred = min(light.scene_referred / samples, vec3(kLargestLight));
  light.scene_referred = mix(light.scene_referred, vec3(0), isnan(light.scene_referred));  // filters would spread it
  light.share /= samples;
  light.display_referred /= samples;
  return light;
}

#endif
