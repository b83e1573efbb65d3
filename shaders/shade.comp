// Shades what the visibility buffer holds, each distinct triangle of a pixel once, and tone-maps and averages the
// samples as the forward path's resolve does. Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_UNRESOLVED leaves linear samples,
// for what is drawn on top.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"
#include "common/shading.glsl"
#include "common/shadow_maps.glsl"
#include "common/shadow_ray.glsl"
#include "common/shadow_mask.glsl"
#include "common/tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadePush push; };
#ifndef FIRE3DV_UNRESOLVED
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D display;
#elif FIRE3DV_SAMPLES == 4
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2DMS hdr;
#else
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2D hdr;
#endif

int shaded_sample;  // the first of those that are being shaded

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  if (globals.value.shadows == FIRE3DV_SHADOWS_MAP) {
    const vec3 lifted = point.position_world + point.lift_m * lit_side(point, light);
    return map_visibility(globals, shadow, lifted, point.plane_normal_world, light);
  }
  const uint pixel = gl_GlobalInvocationID.y * globals.value.width + gl_GlobalInvocationID.x;
  return mask_visibility(globals, shadow, pixel, shaded_sample);
}

vec3 shaded(GlobalsRef globals, uint id, vec2 place) {
  const VisibleTriangle triangle = visible_triangle(globals, id);
  const SurfacePoint point = surface_point(globals, triangle, place);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[triangle.material];
  return shade(globals, material, surface_base_color(material, point), point).rgb;
}

// At the pixel's middle whatever part of it is free, as the raster pipeline has it.
vec3 background_of(GlobalsRef globals, uvec2 pixel) {
  const vec2 ndc = (vec2(pixel) + 0.5) / vec2(globals.value.width, globals.value.height) * 2 - 1;
  return background_radiance(globals, globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
                                          globals.value.world_from_ndc_origin);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  const PixelIds ids = pixel_ids(push.visibility, pixel.y * globals.value.width + pixel.x);
  vec3 sum = vec3(0);
  uint open = kAllSamples;
  while (open != 0) {
    const int s = findLSB(open);
    const uint id = id_of_sample(ids, s), same = samples_with(ids, id);
    open &= ~same;
    shaded_sample = s;
    const vec3 color = id == 0 ? background_of(globals, pixel) : shaded(globals, id, place_of_samples(pixel, same));
#ifndef FIRE3DV_UNRESOLVED
    sum += display_linear(color, push.exposure, push.tone_map) * bitCount(same);
#elif FIRE3DV_SAMPLES == 4
    for (int other = s; other < FIRE3DV_SAMPLES; ++other) {
      if ((same & (1u << other)) != 0) imageStore(hdr, ivec2(pixel), other, vec4(color, 1));
    }
#else
    imageStore(hdr, ivec2(pixel), vec4(color, 1));
#endif
  }
#ifndef FIRE3DV_UNRESOLVED
  imageStore(display, ivec2(pixel), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
#endif
}
