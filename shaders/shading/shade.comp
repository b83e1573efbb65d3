// Deferred shading of the visibility buffer: shades each distinct triangle of a pixel once, tone-maps, and
// averages samples like the forward path's resolve.
// Variants: FIRE3DV_SAMPLES 1 or 4. FIRE3DV_UNRESOLVED writes linear samples, for forward-only draws, effects and
// the linear plane; for the plane alone it tone-maps as well, so that colours are those of an image without it.
// FIRE3DV_TEST_MAPS tests the shadow maps of hard lights; pixels with unresolved shadows are listed for the
// deferred re-shade after the rays. FIRE3DV_RAY_EFFECTS reads reflections, refraction and ambient occlusion.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "common/push_of_group.glsl"
#include "shading/pixel_surfaces.glsl"
#include "common/visible_triangle.glsl"
#include "shading/shading.glsl"
#include "shading/shadow_maps.glsl"
#include "shading/shadow_ray.glsl"
#include "shading/shadow_mask.glsl"
#include "shading/ground.glsl"
#ifdef FIRE3DV_TEST_MAPS
#include "shading/ray_list.glsl"
#include "shading/shadow_test.glsl"
#endif
#include "common/tone_map.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadePush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(ShadePush, ShadePushRef, globals, gl_WorkGroupID.z)
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D display;
#ifdef FIRE3DV_UNRESOLVED
#if FIRE3DV_SAMPLES == 4
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2DMS hdr;
#else
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2D hdr;
#endif
#define tone_maps (push.hdr_end_x == 0)
#else
#define tone_maps true
#endif

// State of the surface being shaded.
uint shaded_pixel;
uint shaded_samples;
#ifdef FIRE3DV_TEST_MAPS
uint shaded_part;
bool shaded_body;
uint known_shadows;  // bits as in the mask
uint wanted_rays;    // as in RayEntry
#endif

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (shadows_of(globals) == FIRE3DV_SHADOWS_OFF) return 1;
  const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
#ifdef FIRE3DV_TEST_MAPS
  if (shadow.rays == 0) return 1;
  vec3 origin;
  const uint shadow_state = shadow_test(globals, shadow, light_index, light, point, shaded_part, shaded_body, origin);
  if (shadow_state == kLit) return 1;
  const uint lit = shaded_samples << shadow.mask_shift;
  known_shadows &= ~lit;
  if (shadow_state == kUnresolved) {
    wanted_rays |= lit & -lit;
    append(push.lists, push.listed_rays, push.ray_list_capacity, globals.value.width * globals.value.height,
           ListedRay(origin, light_index, shaded_pixel, lit));
  }
  return 0;
#else
  if (shadows_of(globals) == FIRE3DV_SHADOWS_MAP) {
    return map_visibility(globals, shadow, map_point(point, light), point.plane_normal_world, light);
  }
  return mask_visibility(globals, shadow, shaded_pixel, findLSB(shaded_samples));
#endif
}

vec3 shaded(GlobalsRef globals, uint id, vec2 position) {
  const VisibleTriangle triangle = visible_triangle(globals, id);
  const SurfacePoint point = surface_point(globals, triangle, position);
#ifdef FIRE3DV_TEST_MAPS
  shaded_part = part_of_id(globals, id);
  shaded_body = is_closed_mesh(globals, shaded_part);
  known_shadows = FIRE3DV_NO_INDEX;  // all lit
  wanted_rays = 0;
#endif
  const MaterialRecord material = MaterialRef(globals.value.materials).at[triangle.material];
#ifdef FIRE3DV_RAY_EFFECTS
  vec3 behind;
  const vec3 color = shade(globals, material, surface_base_color(material, point), point, behind).rgb;
  if ((material.flags & FIRE3DV_MATERIAL_TRANSMISSION) == 0 || !ray_effect.has_refracted) return color;
  const uvec2 pixel = uvec2(shaded_pixel % globals.value.width, shaded_pixel / globals.value.width);
  return min(color + behind * refracted_at(globals, push.visibility, push.ray_effects, pixel, id, shaded_samples), vec3(65504));
#else
  return shade(globals, material, surface_base_color(material, point), point).rgb;
#endif
}

vec3 color_of(GlobalsRef globals, uint id, uvec2 pixel, uint samples) {
  const vec2 position = position_of_samples(pixel, samples);
  if (id == 0) {
    is_display_referred = is_background_display_referred(globals);
    return background_of(globals, vec2(pixel) + 0.5, position - vec2(pixel) - 0.5);
  }
  shaded_pixel = pixel.y * globals.value.width + pixel.x;
  shaded_samples = samples;
#ifdef FIRE3DV_RAY_EFFECTS
  ray_effect = ray_effect_at(globals, push.visibility, push.ray_effects, pixel, id, samples);
#endif
  return shaded(globals, id, position);
}

// Pixel of a lane: of the image, or of the list in a re-shade. Invalid pixels lie outside of the image.
uvec2 pixel_of_lane(GlobalsRef globals, uint lane) {
  if (push.listed == 0) return gl_WorkGroupID.xy * 8 + uvec2(lane & 7, lane >> 3);
  const uint index = (gl_WorkGroupID.x + gl_WorkGroupID.y * 65535) * 64 + lane;
  if (index >= RayListRef(push.lists).at[FIRE3DV_LIST_PIXELS].width) return uvec2(FIRE3DV_NO_INDEX);
  const uint pixel = RayEntryRef(push.entries).at[index].pixel;
  return uvec2(pixel % globals.value.width, pixel / globals.value.width);
}

#ifdef FIRE3DV_TEST_MAPS
void list_pixel(GlobalsRef globals, uint pixel, bool inside, uint known, uint wanted) {
  if (inside && wanted != 0) UintsRef(globals.value.shadow_mask).at[pixel] = known;
  append(push.lists, push.entries, RayEntry(pixel, 0, inside ? wanted : 0));
}
#endif

#if FIRE3DV_SAMPLES == 1
void main() {
  push = push_of_group();
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = pixel_of_lane(globals, gl_LocalInvocationIndex);
  const bool inside = pixel.x < globals.value.width && pixel.y < globals.value.height;
  const uint index = pixel.y * globals.value.width + pixel.x;
  uint id = 0;
  if (inside) {
    id = pixel_ids(globals, push.visibility, index);
    const vec3 color = color_of(globals, id, pixel, 1);
#ifdef FIRE3DV_UNRESOLVED
    imageStore(hdr, ivec2(pixel), vec4(round_to_halves(color), is_display_referred ? 0 : 1));
#endif
    if (tone_maps) imageStore(display, ivec2(pixel.x, pixel.y + push.first_row), vec4(encode_srgb(display_linear(color, is_display_referred, push.exposure, push.tone_map)), 1));
  }
#ifdef FIRE3DV_TEST_MAPS
  list_pixel(globals, index, id != 0, known_shadows, id != 0 ? wanted_rays : 0);
#endif
}
#else
shared vec3 shares[4 * kPixels];  // of a pixel's sum
#ifdef FIRE3DV_TEST_MAPS
shared uint pixel_known[kPixels], pixel_wanted[kPixels];
#endif

void main() {
  push = push_of_group();
  GlobalsRef globals = GlobalsRef(push.globals);
  const uint lane = gl_LocalInvocationIndex;
  const uvec2 own_pixel = pixel_of_lane(globals, lane);
  const bool inside = own_pixel.x < globals.value.width && own_pixel.y < globals.value.height;
  const uint own_index = own_pixel.y * globals.value.width + own_pixel.x;
#ifdef FIRE3DV_TEST_MAPS
  pixel_known[lane] = FIRE3DV_NO_INDEX;
  pixel_wanted[lane] = 0;
#endif
  const OwnSurfaces own = list_surfaces(globals, push.visibility, own_index, inside);
  for (uint slot = lane; slot < surface_count(); slot += kPixels) {
    const PixelSurface surface = surface_at(slot);
    if (surface.samples == 0) continue;
    const uvec2 pixel = pixel_of_lane(globals, surface.lane);
    const vec3 color = color_of(globals, surface.id, pixel, surface.samples);
#ifdef FIRE3DV_TEST_MAPS
    if (surface.id != 0 && known_shadows != FIRE3DV_NO_INDEX) {
      atomicAnd(pixel_known[surface.lane], known_shadows);
      if (wanted_rays != 0) atomicOr(pixel_wanted[surface.lane], wanted_rays);
    }
#endif
#ifdef FIRE3DV_UNRESOLVED
    for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
      if ((surface.samples & (1u << s)) != 0) imageStore(hdr, ivec2(pixel), s, vec4(round_to_halves(color), is_display_referred ? 0 : 1));
    }
#endif
    if (tone_maps) shares[slot] = display_linear(color, is_display_referred, push.exposure, push.tone_map) * bitCount(surface.samples);
  }
#ifndef FIRE3DV_TEST_MAPS
  if (!tone_maps) return;
#endif
  barrier();
#ifdef FIRE3DV_TEST_MAPS
  list_pixel(globals, own_index, inside, pixel_known[lane], pixel_wanted[lane]);
#endif
  if (!inside || !tone_maps) return;
  vec3 sum = shares[lane];  // fixed order of summation
  for (uint i = 1; i < own.count; ++i) sum += shares[own.further + i - 1];
  imageStore(display, ivec2(own_pixel.x, own_pixel.y + push.first_row), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
}
#endif
