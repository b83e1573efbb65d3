// Shadow classification of all pixels: lit and shadowed samples go to the mask, unknown ones to the ray list.
// Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shading/pixel_surfaces.glsl"
#include "shading/ray_list.glsl"
#include "shading/shadow_points.glsl"
#include "shading/shadow_verdict.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadowPush push; };

// Mask bits and required rays of one surface of a pixel.
struct Findings {
  uint known;
  uint wanted;
};

Findings look_at(GlobalsRef globals, uint id, uvec2 pixel, uint same, uint word) {
  Findings found = Findings(FIRE3DV_NO_INDEX, 0);  // all lit
  const int s = findLSB(same);
  const VisibleTriangle triangle = visible_triangle(globals, id);
  const SurfacePoint point = surface_point(globals, triangle, place_of_samples(pixel, same));
  const bool body = push.hybrid != 0 && is_body(globals, part_of_id(globals, id));
  if ((MaterialRef(globals.value.materials).at[point.material].flags & FIRE3DV_MATERIAL_UNLIT) != 0) return found;
  for (uint i = 0; i < globals.value.light_count; ++i) {
    const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[i];
    if (shadow.mask_word != word) continue;
    const LightSample light = sample_light(globals, i, point.position_world);
    if (!light_matters(globals, point, light)) continue;
    uint verdict = kUnknown;
    vec3 origin;
    if (push.hybrid != 0) verdict = shadow_verdict(globals, shadow, i, light, point, part_of_id(globals, id), body, origin);
    if (verdict == kLit) continue;
    if (shadow.rays == 1) {
      found.known &= ~(same << shadow.mask_shift);
      if (verdict == kUnknown) found.wanted |= 1u << (shadow.mask_shift + s);
    } else {
      found.known &= ~(255u << (8 * s));
      found.wanted |= 1u << s;
    }
  }
  return found;
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
  Findings found = Findings(FIRE3DV_NO_INDEX, 0);
#if FIRE3DV_SAMPLES == 4
  const uint lane = gl_LocalInvocationIndex;
  pixel_known[lane] = found.known;
  pixel_wanted[lane] = found.wanted;
  list_surfaces(globals, push.visibility, entry.pixel, inside);
  for (uint place = lane; place < surface_count(); place += kPixels) {
    const PixelSurface surface = surface_at(place);
    if (surface.id == 0) continue;
    found = look_at(globals, surface.id, gl_WorkGroupID.xy * 8 + uvec2(surface.lane & 7, surface.lane >> 3), surface.samples, entry.word);
    if (found.known != FIRE3DV_NO_INDEX) atomicAnd(pixel_known[surface.lane], found.known);
    if (found.wanted != 0) atomicOr(pixel_wanted[surface.lane], found.wanted);
  }
  barrier();
  found = Findings(pixel_known[lane], pixel_wanted[lane]);
#else
  const uint id = inside ? pixel_ids(globals, push.visibility, entry.pixel) : 0;
  if (id != 0) found = look_at(globals, id, own_pixel, 1, entry.word);
#endif
  if (inside) UintsRef(globals.value.shadow_mask).at[entry.pixel * globals.value.mask_words + entry.word] = found.known;
  entry.wanted = found.wanted;
  count_rays(push.lists, bitCount(entry.wanted));
  append(push.lists, push.entries, entry);
}
