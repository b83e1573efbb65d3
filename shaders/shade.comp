// Shades what the visibility buffer holds, each distinct triangle of a pixel once, and tone-maps and averages the
// samples as the forward path's resolve does. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/visible_triangle.glsl"
#include "common/shading.glsl"
#include "common/shadow_maps.glsl"
#include "common/tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadePush push; };
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D display;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SampleRef { uvec2 at[]; };  // id, depth

int shaded_sample;  // the first of those that are being shaded

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  if (globals.value.shadows == FIRE3DV_SHADOWS_MAP) {
    return map_visibility(globals, shadow, point.position_world, point.plane_normal_world, light);
  }
  const uint pixel = gl_GlobalInvocationID.y * globals.value.width + gl_GlobalInvocationID.x;
  const uint word = UintRef(globals.value.shadow_mask).at[pixel * globals.value.mask_words + shadow.mask_word];
  if (shadow.rays == 1) return (word >> (shadow.mask_shift + shaded_sample)) & 1;
  return ((word >> (8 * shaded_sample)) & 255) / 255.0;
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
  const uint first = (pixel.y * globals.value.width + pixel.x) * FIRE3DV_SAMPLES;
  uint ids[FIRE3DV_SAMPLES];
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) ids[s] = SampleRef(push.visibility).at[first + s].x;

  vec3 sum = vec3(0);
  uint done = 0;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    if ((done & (1u << s)) != 0) continue;
    // At the pixel's middle when the triangle has all of it, as the raster pipeline interpolates at centroids.
    int count = 0;
    vec2 place = vec2(0);
    for (int other = s; other < FIRE3DV_SAMPLES; ++other) {
      if (ids[other] != ids[s]) continue;
      done |= 1u << other;
      ++count;
      place += vec2(kSamplePosition[other]) / 256;
    }
    shaded_sample = s;
    place = count == FIRE3DV_SAMPLES ? vec2(0.5) : place / count;
    const vec3 color =
        ids[s] == 0 ? background_of(globals, pixel) : shaded(globals, ids[s], vec2(pixel) + place);
    sum += display_linear(color, push.exposure, push.tone_map) * count;
  }
  imageStore(display, ivec2(pixel), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
}
