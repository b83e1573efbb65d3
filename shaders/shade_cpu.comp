// shade.comp for a device that is a CPU (see lanes.glsl): the same surfaces by the same text, in an order that suits it.
// What rays tell is in the mask. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"
#include "common/shading.glsl"
#include "common/shadow_maps.glsl"
#include "common/shadow_ray.glsl"
#include "common/shadow_mask.glsl"
#include "common/tone_map.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ShadePush push; };
layout(set = 1, binding = FIRE3DV_BINDING_DISPLAY, rgba8) uniform writeonly image2D display;

struct HeldShadow {
  LightShadow shadow;
  RasterView view;  // the first
};

GlobalsRef globals;
HeldShadow held_shadows[kHeldLights];  // of the first lights
uint shaded_pixel;
int shaded_sample;  // the first of those that are being shaded

void hold_shadows() {
  if (globals.value.light_count == 0 || globals.value.shadows == FIRE3DV_SHADOWS_OFF) return;
  for (uint i = 0; i < kHeldLights; ++i) {
    held_shadows[i].shadow = LightShadowRef(globals.value.light_shadows).at[min(i, globals.value.light_count - 1)];
    if (globals.value.shadows == FIRE3DV_SHADOWS_MAP && held_shadows[i].shadow.view_count != 0) {
      held_shadows[i].view = view_for_all(globals.value.light_views, held_shadows[i].shadow.first_view);
    }
  }
}

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  const bool held = light_index < kHeldLights;
  LightShadow shadow;
  if (held) {
    shadow = held_shadows[light_index].shadow;
  } else {
    shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  }
  if (shadow.rays == 0) return 1;
  if (globals.value.shadows != FIRE3DV_SHADOWS_MAP) return mask_visibility(globals, shadow, shaded_pixel, shaded_sample);
  const vec3 lifted = point.position_world + point.lift_m * lit_side(point, light);
  RasterView view;
  if (held && shadow.view_count == 1) {
    view = held_shadows[light_index].view;
  } else {
    view = view_of(globals, shadow, light);
  }
  return map_visibility(globals, view, lifted, point.plane_normal_world, light);
}

// together: no lane is missing.
vec3 shaded(uint id, vec2 place, const bool together) {
  const VisibleTriangle triangle = visible_triangle(globals, id, together);
  const SurfacePoint point = surface_point(globals, triangle, place);
  const MaterialRecord material = material_of(globals, triangle);
  return shade(globals, material, surface_base_color(material, point), point).rgb;
}

vec3 background_of(uvec2 pixel) {
  const vec2 ndc = (vec2(pixel) + 0.5) / vec2(globals.value.width, globals.value.height) * 2 - 1;
  return background_radiance(globals, globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
                                          globals.value.world_from_ndc_origin);
}

// Every pixel has a lane, or those have one that were listed. Blocks of 4 x 2 pixels for each vector: fewer of them lie on
// the border between two bodies than of rows of 8. What is beyond the image or the list repeats the last, so that no lane
// is missing.
uvec2 pixel_of_lane() {
  const uint i = gl_LocalInvocationID.x;
  if (push.listed != 0) {
    const uint last = RayListRef(push.list).value.width - 1;
    const uint index = min((gl_WorkGroupID.x + gl_WorkGroupID.y * 65535) * 64 + i, last);
    const uint pixel = RayEntryRef(push.entries).at[index].pixel;
    return uvec2(pixel % globals.value.width, pixel / globals.value.width);
  }
  const uvec2 place = uvec2((i & 3) | ((i >> 1) & 4), ((i >> 2) & 1) | ((i >> 3) & 6));
  return min(gl_WorkGroupID.xy * 8 + place, uvec2(globals.value.width, globals.value.height) - 1);
}

void main() {
  globals = globals_at(push.globals);
  const uvec2 pixel = pixel_of_lane();
  shaded_pixel = pixel.y * globals.value.width + pixel.x;
  const PixelIds ids = pixel_ids(push.visibility, shaded_pixel);
  hold_lights(globals);
  hold_shadows();

  // The first surface of all lanes' pixels: where there is none a neighbour's stands in.
  const uint id = id_of_sample(ids, 0), same = samples_with(ids, id), other_id = largest_of_lanes(id);
  vec3 color = vec3(0);
  shaded_sample = 0;
  if (other_id != 0) color = shaded(id != 0 ? id : other_id, place_of_samples(pixel, same), true);
  if (id == 0) color = background_of(pixel);
  vec3 sum = display_linear(color, push.exposure, push.tone_map) * bitCount(same);

#if FIRE3DV_SAMPLES == 4
  // The others of pixels on edges.
  uint open = kAllSamples & ~same;
  while (open != 0) {
    shaded_sample = findLSB(open);
    const uint further_id = id_of_sample(ids, shaded_sample), further = samples_with(ids, further_id);
    open &= ~further;
    const vec3 further_color = further_id == 0 ? background_of(pixel)
                                               : shaded(further_id, place_of_samples(pixel, further), false);
    sum += display_linear(further_color, push.exposure, push.tone_map) * bitCount(further);
  }
#endif
  imageStore(display, ivec2(pixel), vec4(encode_srgb(sum / FIRE3DV_SAMPLES), 1));
}
