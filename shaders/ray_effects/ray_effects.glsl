// Ray effects of visible surfaces: mirror and glossy reflections, refraction, and ambient occlusion. Rays end at the
// first opaque surface. All surfaces are shaded by the raster's material model (shading.glsl): lamps with shadow rays,
// and the environment.
//
// Sample patterns depend on the pixel alone: 16 pixels of a block of 4 x 4 share one sequence, so that shading can
// average the block (ray_effect_lookup.glsl). The including shader traces rays: closest_hit() and is_shadowed().
#ifndef FIRE3DV_RAY_EFFECTS_GLSL
#define FIRE3DV_RAY_EFFECTS_GLSL
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"
#include "material/brdf_sampling.glsl"
#include "path/hit.glsl"
#include "ray_effects/traced_lobe.glsl"
#include "shading/light_rays.glsl"
#include "shading/shading.glsl"

layout(push_constant, scalar) uniform Push { RayEffectsPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer RayEffectOut { RayEffectRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer RefractedOut { uvec2 at[]; };

Hit closest_hit(vec3 origin, vec3 direction, float distance_m, bool meets_all);

const float kFar = 1e30;

uint traced_pixel;

// Shadow of a light at a hit.
float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  shadow.rays = min(shadow.rays, push.reflection_rays);  // as many as the pixel has rays to the hits
  const vec3 origin =
      offset_from_surface(point.position_world, lit_side(point, light), point.position_world, 0, point.lift_m);
  return light_that_arrives(globals, shadow, light_index, light, origin, traced_pixel);
}

#include "ray_effects/radiance_through.glsl"

// Point k of the pixel's part of the R2 sequence (Roberts 2018), from 0 to 1. count: points of a pixel.
vec2 sample_point(uvec2 pixel, uint k, uint count) {
  const uint in_block = (pixel.x & 3) + 4 * (pixel.y & 3);
  // Neighbours get parts of the sequence that are far apart.
  const uint part = (in_block * 7) & 15;
  return fract(0.5 + float(part * count + k + 1) * vec2(0.7548776662, 0.5698402910));
}

// Radiance of one lobe, averaged over its rays.
struct LobeRadiance {
  vec3 sum;
  float count, hits;
  float away;  // share of the distance to the eye's image that lies behind the surface, summed
};

LobeRadiance averaged(LobeRadiance lobe) {
  const float scale = 1 / max(lobe.count, 1);
  return LobeRadiance(scale * lobe.sum, lobe.count, scale * lobe.hits, scale * lobe.away);
}

// Width of a lobe's blur in pixels: the standard deviation of mirrored directions, about alpha, seen from the eye.
float blur_of(Lobe lobe, float away) {
  return is_mirror(lobe) || push.pixel_angle_rad <= 0 ? 0 : lobe.alpha * away / push.pixel_angle_rad;
}

// One loop for reflected and refracted rays, so that the material model occurs once in the code.
void trace_lobes(GlobalsRef globals, MaterialRecord material, Surface surface, SurfacePoint point, uvec2 pixel,
                 inout RayEffect effect, inout RefractedLight refracted) {
  const Lobe lobe = traced_lobe(surface);
  const float share = (push.effects & FIRE3DV_RAY_EFFECT_REFLECTIONS) != 0 ? traced_share(lobe) : 0;
  const uint reflected_rays = share <= 0 ? 0 : is_mirror(lobe) ? 1 : push.reflection_rays;
  const bool transmits = kExtensions && (push.effects & FIRE3DV_RAY_EFFECT_REFRACTION) != 0 && largest(surface.transmitted) > 0;
  const uint refracted_rays = !transmits ? 0 : is_mirror(surface.base) ? 1 : push.reflection_rays;
  const bool bends = transmits && is_volume(material);
  const vec3 plane = point.plane_normal_world, eye = globals.value.eye_world;
  const float eye_distance_m = distance(eye, point.position_world);
  LobeRadiance mirrored = LobeRadiance(vec3(0), 0, 0, 0), passed = LobeRadiance(vec3(0), 0, 0, 0);
  for (uint k = 0; k < reflected_rays + refracted_rays; ++k) {
    const bool reflects = k < reflected_rays;
    Lobe by = surface.base;
    if (reflects) by = lobe;
    const vec3 facets = is_mirror(by) ? reflect(-surface.to_eye, by.normal)
                                      : sample_facets(by, surface.to_eye,
                                                      sample_point(pixel, reflects ? k : k - reflected_rays,
                                                                   reflects ? reflected_rays : refracted_rays));
    vec3 direction = facets;
    if (bends && !reflects) {
      const float ior = medium_ior(globals, point.material, 0);
      direction = normalize(refract(-surface.to_eye, normalize(facets + surface.to_eye), 1 / ior));
    } else if (!reflects) {
      direction = mirrored_at(by.normal, facets);
    }
    if (reflects) mirrored.count += 1;
    // Directions on the wrong side of the triangle: reflections take the environment, transmission has fewer rays.
    if ((dot(direction, plane) > 0) != reflects) continue;
    const vec3 origin = offset_from_surface(point.position_world, reflects ? plane : -plane, eye, point.pixel_size_m,
                                            reflects ? point.lift_m : 0);
    const uvec4 outside = uvec4(FIRE3DV_NO_INDEX);
    float distance_m;
    const vec3 radiance =
        radiance_through(globals, origin, direction, bends && !reflects ? media_behind(outside, point.material, false) : outside,
                         eye_distance_m, by.roughness, distance_m);
    const float away = distance_m < kFar ? distance_m / (distance_m + eye_distance_m) : 1;
    if (!reflects) {
      passed = LobeRadiance(passed.sum + radiance, passed.count + 1, 0, passed.away + away);
      continue;
    }
    mirrored.away += away;
    if (distance_m < kFar) mirrored = LobeRadiance(mirrored.sum + radiance, mirrored.count, mirrored.hits + 1, mirrored.away);
  }
  mirrored = averaged(mirrored);
  effect.reflected = share * mirrored.sum;
  effect.missed = 1 - share * mirrored.hits;
  effect.blur = blur_of(lobe, mirrored.away);
  passed = averaged(passed);
  refracted = RefractedLight(passed.sum, blur_of(surface.base, passed.away));
}

// Share of the hemisphere, weighted by the cosine, without a surface nearby.
void trace_occlusion(SurfacePoint point, uvec2 pixel, inout RayEffect effect) {
  GlobalsRef globals = GlobalsRef(push.globals);
  const vec3 origin = offset_from_surface(point.position_world, point.plane_normal_world, globals.value.eye_world,
                                          point.pixel_size_m, point.lift_m);
  uint blocked = 0, rays = 0;
  for (uint k = 0; k < push.occlusion_rays; ++k) {
    const vec3 direction = sample_cosine(point.normal_world, sample_point(pixel, k, push.occlusion_rays));
    if (dot(direction, point.plane_normal_world) <= 0) continue;
    ++rays;
    if (is_shadowed(globals, origin, direction, push.occlusion_distance_m)) ++blocked;
  }
  effect.open = rays == 0 ? 1 : 1 - float(blocked) / rays;
  effect.has_occlusion = true;
}

// n-th distinct surface of a pixel as the samples that show it; 0: there are fewer. The background is none.
uint samples_of_surface(PixelIds ids, uint n) {
  uint open = kAllSamples & ~samples_with(ids, 0);
  for (uint i = 0; i < n; ++i) {
    if (open != 0) open &= ~samples_with(ids, id_of_sample(ids, findLSB(open)));
  }
  return open == 0 ? 0 : samples_with(ids, id_of_sample(ids, findLSB(open)));
}

void trace_effects(uvec2 pixel) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  traced_pixel = pixel.y * globals.value.width + pixel.x;
  const PixelIds ids = pixel_ids(globals, push.visibility, traced_pixel);
  const uint samples = samples_of_surface(ids, push.surface);
  if (samples == 0) return;
  const int first = findLSB(samples);
  const VisibleTriangle triangle = visible_triangle(globals, id_of_sample(ids, first));
  const SurfacePoint point = surface_point(globals, triangle, position_of_samples(pixel, samples));
  const MaterialRecord material = MaterialRef(globals.value.materials).at[triangle.material];
  RayEffect effect = no_ray_effect();
  RefractedLight refracted = RefractedLight(vec3(0), 0);
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) == 0) {
    const uint lobes = FIRE3DV_RAY_EFFECT_REFLECTIONS | FIRE3DV_RAY_EFFECT_REFRACTION;
    if ((push.effects & lobes) != 0) {
      const vec3 to_eye = normalize(globals.value.eye_world - point.position_world);
      const Surface surface = make_surface(globals, material, surface_base_color(material, point), point, to_eye);
      trace_lobes(globals, material, surface, point, pixel, effect, refracted);
    }
    if ((push.effects & FIRE3DV_RAY_EFFECT_OCCLUSION) != 0)
      trace_occlusion(point, pixel, effect);
  }
  const uint index = traced_pixel * FIRE3DV_SAMPLES + first;
  effect.has_refracted = kExtensions && (push.effects & FIRE3DV_RAY_EFFECT_REFRACTION) != 0;
  RayEffectOut(push.records).at[index] = pack_ray_effect(effect, point.normal_world);
  if (effect.has_refracted)
    RefractedOut(refracted_records(globals, push.records)).at[index] = pack_refracted(refracted);
}

#endif
