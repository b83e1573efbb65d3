// Shades what the visibility buffer holds, each distinct triangle of a pixel once, and tone-maps and averages the
// samples as the forward path's resolve does. Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_UNRESOLVED leaves linear samples,
// for what is drawn on top.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_surfaces.glsl"
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

uint shaded_pixel;
int shaded_sample;  // the first of those that are being shaded

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  if (globals.value.shadows == FIRE3DV_SHADOWS_MAP) {
    const vec3 lifted = point.position_world + point.lift_m * lit_side(point, light);
    return map_visibility(globals, shadow, lifted, point.plane_normal_world, light);
  }
  return mask_visibility(globals, shadow, shaded_pixel, shaded_sample);
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

vec3 color_of(GlobalsRef globals, uint id, uvec2 pixel, uint samples) {
  if (id == 0) return background_of(globals, pixel);
  shaded_pixel = pixel.y * globals.value.width + pixel.x;
  shaded_sample = findLSB(samples);
  return shaded(globals, id, place_of_samples(pixel, samples));
}

#if FIRE3DV_SAMPLES == 1
void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  const uint id = pixel_ids(push.visibility, pixel.y * globals.value.width + pixel.x);
  const vec3 color = color_of(globals, id, pixel, 1);
#ifdef FIRE3DV_UNRESOLVED
  imageStore(hdr, ivec2(pixel), vec4(color, 1));
#else
  imageStore(display, ivec2(pixel), vec4(encode_srgb(display_linear(color, push.exposure, push.tone_map)), 1));
#endif
}
#else
#ifndef FIRE3DV_UNRESOLVED
shared vec3 shares[4 * kPixels];  // of a pixel's sum
#endif

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 own_pixel = gl_GlobalInvocationID.xy;
  const bool inside = own_pixel.x < globals.value.width && own_pixel.y < globals.value.height;
  const OwnSurfaces own = list_surfaces(push.visibility, own_pixel.y * globals.value.width + own_pixel.x, inside);
  for (uint place = gl_LocalInvocationIndex; place < surface_count(); place += kPixels) {
    const PixelSurface surface = surface_at(place);
    if (surface.samples == 0) continue;
    const uvec2 pixel = pixel_of_lane(surface.lane);
    const vec3 color = color_of(globals, surface.id, pixel, surface.samples);
#ifdef FIRE3DV_UNRESOLVED
    for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
      if ((surface.samples & (1u << s)) != 0) imageStore(hdr, ivec2(pixel), s, vec4(color, 1));
    }
#else
    shares[place] = display_linear(color, push.exposure, push.tone_map) * bitCount(surface.samples);
#endif
  }
#ifndef FIRE3DV_UNRESOLVED
  barrier();
  if (!inside) return;
  vec3 sum = shares[gl_LocalInvocationIndex];  // always in the same order
  for (uint i = 1; i < own.count; ++i) sum += shares[own.further + i - 1];
  imageStore(display, ivec2(own_pixel), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
#endif
}
#endif
