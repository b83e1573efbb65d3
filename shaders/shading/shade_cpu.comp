// Variant of shading/shade.comp for devices that are a CPU (see lanes.glsl): the same includes, in an order that
// suits vectors.
// Variants: as in shading/shade.comp, but FIRE3DV_TEST_MAPS also performs the deferred re-shade of listed pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "common/push_of_group.glsl"
#include "visibility/interleaved_groups.glsl"
#include "common/pixel_ids.glsl"
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

layout(local_size_x = 8) in;  // for 64 pixels, see main
layout(push_constant, scalar) uniform Push { ShadePush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(ShadePush, ShadePushRef, globals, gl_WorkGroupID.z)
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D display;
#ifdef FIRE3DV_UNRESOLVED
#if FIRE3DV_SAMPLES == 4
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2DMS hdr;
#else
layout(set = 1, binding = FIRE3DV_BINDING_HDR, rgba16f) uniform writeonly image2D hdr;
#endif
#endif

struct CachedShadow {
  LightShadow shadow;
  RasterView view;  // the first view
};

GlobalsRef globals;
CachedShadow cached_shadows[kCachedLights];  // of the first lights
uvec2 group;        // of the image
uint first_listed;  // first list entry of the group, in a re-shade
uint lane_pixel;    // index in the group's 64 pixels
uint shaded_pixel;
uint shaded_samples;  // of that pixel, as bits
#ifdef FIRE3DV_TEST_MAPS
uint shaded_part;
bool shaded_body;
bool is_own_surface;  // false for stand-in surfaces (see shade_pixel) and for duplicated pixels
uint known_shadows;  // of the pixel, bits as in the mask
uint wanted_rays;    // as in RayEntry
#endif

void hold_shadows() {
  if (globals.value.light_count == 0 || shadows_of(globals) == FIRE3DV_SHADOWS_OFF) return;
  for (uint i = 0; i < kCachedLights; ++i) {
    cached_shadows[i].shadow = LightShadowRef(globals.value.light_shadows).at[min(i, globals.value.light_count - 1)];
#ifdef FIRE3DV_TEST_MAPS
    const bool asks_maps = true;
#else
    const bool asks_maps = shadows_of(globals) == FIRE3DV_SHADOWS_MAP;
#endif
    if (asks_maps && cached_shadows[i].shadow.view_count != 0) {
      cached_shadows[i].view = view_for_all(globals.value.light_views, cached_shadows[i].shadow.first_view);
    }
  }
}

RasterView view_towards(uint light_index, LightShadow shadow, LightSample light) {
  RasterView view;
  if (light_index < kCachedLights && shadow.view_count == 1) {
    view = cached_shadows[light_index].view;
  } else {
    view = view_of(globals, shadow, light);
  }
  return view;
}

#ifdef FIRE3DV_TEST_MAPS
uint test_shadow(uint light_index, LightShadow shadow, LightSample light, SurfacePoint point, out vec3 origin) {
  origin = vec3(0);
  if (shaded_body && is_turned_away(point, light)) return kShadowed;
  LightPose pose;
  if (light_index < kCachedLights) {
    pose = cached_lights[light_index];
  } else {
    pose = LightPoseRef(globals.value.light_poses).at[light_index];
  }
  const ShadowRay ray = shadow_ray(globals, point, pose, light);
  origin = ray.origin;
  const uint shadow_state =
      shadow_map_test(globals, view_towards(light_index, shadow, ray.light), shaded_part, ray.origin, point.plane_normal_world, ray.light);
  return without_front_faces(shadow_state, shaded_body, point, light);
}
#endif

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  if (shadows_of(globals) == FIRE3DV_SHADOWS_OFF) return 1;
  LightShadow shadow;
  if (light_index < kCachedLights) {
    shadow = cached_shadows[light_index].shadow;
  } else {
    shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  }
  if (shadow.rays == 0) return 1;
#ifdef FIRE3DV_TEST_MAPS
  if (push.listed != 0) return mask_visibility(globals, shadow, shaded_pixel, findLSB(shaded_samples));
  vec3 origin;
  const uint shadow_state = test_shadow(light_index, shadow, light, point, origin);
  if (shadow_state == kLit) return 1;
  const uint lit = shaded_samples << shadow.mask_shift;
  known_shadows &= ~lit;
  if (shadow_state == kUnresolved) {
    wanted_rays |= lit & -lit;
    if (is_own_surface) {
      append(push.lists, push.listed_rays, push.ray_list_capacity, globals.value.width * globals.value.height,
             ListedRay(origin, light_index, shaded_pixel, lit));
    }
  }
  return 0;
#else
  if (shadows_of(globals) != FIRE3DV_SHADOWS_MAP) return mask_visibility(globals, shadow, shaded_pixel, findLSB(shaded_samples));
  return map_visibility(globals, view_towards(light_index, shadow, light), map_point(point, light), point.plane_normal_world, light);
#endif
}

// together: all lanes are active.
vec3 shaded(uint id, vec2 position, const bool together) {
  const VisibleTriangle triangle = visible_triangle(globals, id, together);
  const SurfacePoint point = surface_point(globals, triangle, position);
#ifdef FIRE3DV_TEST_MAPS
  shaded_part = part_of_id(globals, id);
  shaded_body = is_closed_mesh(globals, shaded_part);
#endif
  const MaterialRecord material = material_of(globals, triangle);
  return shade(globals, material, surface_base_color(material, point), point).rgb;
}

// A group shades 8 x 8 pixels, or 64 listed ones, in blocks of 2 x 4 pixels per vector. Fewer of these blocks
// cross borders between surfaces than rows of 8. The first two blocks fetch all rows of the visibility
// buffer. Indices beyond the image or list repeat the last one, so that all lanes stay active.
uvec2 position_of_lane() {
  const uint i = lane_pixel;
  return uvec2((i & 1) | ((i >> 3) & 6), (i >> 1) & 7);
}

uvec2 pixel_of_lane() {
  if (push.listed != 0) {
    const uint last = RayListRef(push.lists).at[FIRE3DV_LIST_PIXELS].width - 1;
    const uint index = min(first_listed + lane_pixel, last);
    const uint pixel = RayEntryRef(push.entries).at[index].pixel;
    return uvec2(pixel % globals.value.width, pixel / globals.value.width);
  }
  return min(group * 8 + position_of_lane(), uvec2(globals.value.width, globals.value.height) - 1);
}

vec3 sum;  // of the pixel's samples, display-linear

#ifdef FIRE3DV_UNRESOLVED
bool is_left(uvec2 pixel) {
  return all(greaterThanEqual(pixel, uvec2(push.hdr_x, push.hdr_y))) &&
         all(lessThan(pixel, uvec2(push.hdr_end_x, push.hdr_end_y)));
}
#endif

void put(uvec2 pixel, vec3 color, uint samples) {
#ifdef FIRE3DV_UNRESOLVED
  if (push.keeps_samples != 0 || is_left(pixel)) {
#if FIRE3DV_SAMPLES == 4
    for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
      if ((samples & (1u << s)) != 0) imageStore(hdr, ivec2(pixel), s, vec4(round_to_halves(color), is_display_referred ? 0 : 1));
    }
#else
    imageStore(hdr, ivec2(pixel), vec4(round_to_halves(color), is_display_referred ? 0 : 1));
#endif
  }
  if (is_left(pixel)) return;
#endif
  sum += display_linear(color, is_display_referred, push.exposure, push.tone_map) * bitCount(samples);
}

#ifdef FIRE3DV_TEST_MAPS
void forget_shadows() {
  known_shadows = FIRE3DV_NO_INDEX;  // all lit
  wanted_rays = 0;
}

// False for a pixel repeated at the image's border.
bool is_own_pixel() {
  return all(lessThan(group * 8 + position_of_lane(), uvec2(globals.value.width, globals.value.height)));
}
#endif

// One loop for all surfaces, although most pixels show one: a second copy of the shading code would double
// the compile time.
void shade_pixel() {
  const uvec2 pixel = pixel_of_lane();
  shaded_pixel = pixel.y * globals.value.width + pixel.x;
  const PixelIds ids = pixel_ids(globals, push.visibility, shaded_pixel);
#ifdef FIRE3DV_TEST_MAPS
  forget_shadows();
  const bool own = is_own_pixel();
#endif
  sum = vec3(0);
  uint open = kAllSamples;
  bool together = true;  // first surfaces of all lanes; a background lane shades a neighbour's surface as a
                         // stand-in
  do {
    const uint id = id_of_sample(ids, findLSB(open)), other = largest_of_lanes(id), shown = together && id == 0 ? other : id;
    shaded_samples = samples_with(ids, id);
    open &= ~shaded_samples;
#ifdef FIRE3DV_TEST_MAPS
    is_own_surface = own && id != 0;
#endif
    vec3 color = vec3(0);
    const vec2 position = position_of_samples(pixel, shaded_samples);
    if (shown != 0) color = shaded(shown, position, together);
    if (id == 0) {
#ifdef FIRE3DV_TEST_MAPS
      if (together) forget_shadows();
#endif
      is_display_referred = is_background_display_referred(globals);
      color = background_of(globals, vec2(pixel) + 0.5, position - vec2(pixel) - 0.5);
    }
    put(pixel, color, shaded_samples);
    together = false;
  } while (FIRE3DV_SAMPLES == 4 && open != 0);
#ifdef FIRE3DV_UNRESOLVED
  if (!is_left(pixel))
#endif
    imageStore(display, ivec2(pixel.x, pixel.y + push.first_row), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
#ifdef FIRE3DV_TEST_MAPS
  if (push.listed != 0) return;
  if (own && wanted_rays != 0) UintsRef(globals.value.shadow_mask).at[shaded_pixel] = known_shadows;
  append(push.lists, push.entries, RayEntry(shaded_pixel, 0, own ? wanted_rays : 0));
#endif
}

// One vector shades all pixels of its group, so that uniform data is read once.
void main() {
  push = push_of_group();
  if (is_ended()) return;
  group = image_group();
  first_listed = list_group() * 64;
  globals = globals_at(push.globals);
  hold_lights(globals);
  hold_shadows();
  for (uint i = 0; i < 8; ++i) {
    lane_pixel = 8 * i + gl_LocalInvocationID.x;
    shade_pixel();
  }
}
