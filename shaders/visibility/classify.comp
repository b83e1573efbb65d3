// Shadow classification of all pixels: lit and shadowed samples go to the mask, unresolved ones to the ray list.
// Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shading/pixel_surfaces.glsl"
#include "shading/ray_list.glsl"
#include "shading/shadow_points.glsl"
#include "shading/shadow_test.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadowPush push; };

// Mask bits and required rays of one surface of a pixel.
struct MaskWord {
  uint known;
  uint wanted;
};

MaskWord test_sample(GlobalsRef globals, uint id, uvec2 pixel, uint same, uint word) {
  MaskWord result = MaskWord(FIRE3DV_NO_INDEX, 0);  // all lit
  const int s = findLSB(same);
  const VisibleTriangle triangle = visible_triangle(globals, id);
  const SurfacePoint point = surface_point(globals, triangle, position_of_samples(pixel, same));
  const bool body = push.hybrid != 0 && is_closed_mesh(globals, part_of_id(globals, id));
  if ((MaterialRef(globals.value.materials).at[point.material].flags & FIRE3DV_MATERIAL_UNLIT) != 0) return result;
  for (uint i = 0; i < globals.value.light_count; ++i) {
    const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[i];
    if (shadow.mask_word != word) continue;
    const LightSample light = sample_light(globals, i, point.position_world);
    if (!light_matters(globals, point, light)) continue;
    uint shadow_state = kUnresolved;
    vec3 origin;
    if (push.hybrid != 0) shadow_state = shadow_test(globals, shadow, i, light, point, part_of_id(globals, id), body, origin);
    if (shadow_state == kLit) continue;
    if (shadow.rays == 1) {
      result.known &= ~(same << shadow.mask_shift);
      if (shadow_state == kUnresolved) result.wanted |= 1u << (shadow.mask_shift + s);
    } else {
      result.known &= ~(255u << (8 * s));
      result.wanted |= 1u << s;
    }
  }
  return result;
}

#if FIRE3DV_SAMPLES == 4
shared uint pixel_known[kPixels], pixel_wanted[kPixels];
#endif

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 own_pixel = gl_GlobalInvocationID.xy;
  const bool inside = own_pixel.x < globals.value.width && own_pixel.y < globals.value.height;
  RayEntry entry;
  entry.pixel = own_pixel.y * globals.value.width + own_pixel.x;
  entry.word = gl_GlobalInvocationID.z;
  MaskWord result = MaskWord(FIRE3DV_NO_INDEX, 0);
#if FIRE3DV_SAMPLES == 4
  const uint lane = gl_LocalInvocationIndex;
  pixel_known[lane] = result.known;
  pixel_wanted[lane] = result.wanted;
  list_surfaces(globals, push.visibility, entry.pixel, inside);
  for (uint slot = lane; slot < surface_count(); slot += kPixels) {
    const PixelSurface surface = surface_at(slot);
    if (surface.id == 0) continue;
    result = test_sample(globals, surface.id, gl_WorkGroupID.xy * 8 + uvec2(surface.lane & 7, surface.lane >> 3), surface.samples, entry.word);
    if (result.known != FIRE3DV_NO_INDEX) atomicAnd(pixel_known[surface.lane], result.known);
    if (result.wanted != 0) atomicOr(pixel_wanted[surface.lane], result.wanted);
  }
  barrier();
  result = MaskWord(pixel_known[lane], pixel_wanted[lane]);
#else
  const uint id = inside ? pixel_ids(globals, push.visibility, entry.pixel) : 0;
  if (id != 0) result = test_sample(globals, id, own_pixel, 1, entry.word);
#endif
  if (inside) UintsRef(globals.value.shadow_mask).at[entry.pixel * globals.value.mask_words + entry.word] = result.known;
  entry.wanted = result.wanted;
  count_rays(push.lists, bitCount(entry.wanted));
  append(push.lists, push.entries, entry);
}
