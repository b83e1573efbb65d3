// Ray effects of visible surfaces: mirror and glossy reflections, and ambient occlusion. Rays end at the first
// surface, which the raster's material model shades (shading.glsl): lamps with shadow rays, and the environment.
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

Hit closest_hit(vec3 origin, vec3 direction, float distance_m);

const float kFar = 1e30;
const uint kMaxLightRays = 4;  // from a hit to a soft light

uint traced_pixel;

// Shadow of a light at a hit.
float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
  LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
  shadow.rays = min(shadow.rays, kMaxLightRays);
  const vec3 origin =
      offset_from_surface(point.position_world, lit_side(point, light), point.position_world, 0, point.lift_m);
  return light_that_arrives(globals, shadow, light_index, light, origin, traced_pixel);
}

// Radiance that a surface sends against the direction of the ray that hits it.
vec3 radiance_of_hit(GlobalsRef globals, Hit hit, vec3 direction, out vec3 position_world) {
  const PrimitiveRecord primitive = primitive_of_hit(globals, hit.node, hit.geometry);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  const PathVertex vertex = path_vertex(globals, hit, primitive, material, direction);
  SurfacePoint point = vertex.point;
  point.lift_m = vertex.rounding_m;
  position_world = point.position_world;
  vec3 behind;
  return shade(globals, material, surface_base_color(material, point), point, -direction, behind).rgb;
}

// Point k of the pixel's part of the R2 sequence (Roberts 2018), from 0 to 1. count: points of a pixel.
vec2 sample_point(uvec2 pixel, uint k, uint count) {
  const uint in_block = (pixel.x & 3) + 4 * (pixel.y & 3);
  // Neighbours get parts of the sequence that are far apart.
  const uint part = (in_block * 7) & 15;
  return fract(0.5 + float(part * count + k + 1) * vec2(0.7548776662, 0.5698402910));
}

void trace_reflection(GlobalsRef globals, Surface surface, SurfacePoint point, vec3 origin, uvec2 pixel,
                      inout RayEffect effect) {
  const Lobe lobe = traced_lobe(surface);
  const float share = traced_share(lobe);
  if (share <= 0) return;
  const bool is_mirror = is_mirror(lobe);
  const uint rays = is_mirror ? 1 : push.reflection_rays;
  const float eye_distance_m = distance(globals.value.eye_world, point.position_world);
  vec3 sum = vec3(0);
  float hits = 0, away = 0;  // away: share of the distance to the eye's mirror image that lies behind the surface
  for (uint k = 0; k < rays; ++k) {
    const vec3 direction = is_mirror ? reflect(-surface.to_eye, lobe.normal)
                                     : sample_facets(lobe, surface.to_eye, sample_point(pixel, k, rays));
    // Directions below the triangle take the environment.
    if (dot(direction, point.plane_normal_world) <= 0) continue;
    const Hit hit = closest_hit(origin, direction, kFar);
    if (!hit.found) {
      away += 1;
      continue;
    }
    vec3 position_world;
    sum += radiance_of_hit(globals, hit, direction, position_world);
    hits += 1;
    const float distance_m = distance(origin, position_world);
    away += distance_m / (distance_m + eye_distance_m);
  }
  effect.reflected = share / rays * sum;
  effect.missed = 1 - share * hits / rays;
  // Standard deviation of the mirrored direction, about alpha, seen from the eye.
  if (!is_mirror && push.pixel_angle_rad > 0) effect.blur = lobe.alpha * away / rays / push.pixel_angle_rad;
}

// Share of the hemisphere, weighted by the cosine, without a surface nearby.
void trace_occlusion(SurfacePoint point, vec3 origin, uvec2 pixel, inout RayEffect effect) {
  GlobalsRef globals = GlobalsRef(push.globals);
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
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) == 0) {
    const vec3 origin = offset_from_surface(point.position_world, point.plane_normal_world, globals.value.eye_world,
                                            point.pixel_size_m, point.lift_m);
    if ((push.effects & FIRE3DV_RAY_EFFECT_REFLECTIONS) != 0) {
      const vec3 to_eye = normalize(globals.value.eye_world - point.position_world);
      const Surface surface = make_surface(globals, material, surface_base_color(material, point), point, to_eye);
      trace_reflection(globals, surface, point, origin, pixel, effect);
    }
    if ((push.effects & FIRE3DV_RAY_EFFECT_OCCLUSION) != 0)
      trace_occlusion(point, origin, pixel, effect);
  }
  RayEffectOut(push.records).at[traced_pixel * FIRE3DV_SAMPLES + first] = pack_ray_effect(effect, point.normal_world);
}

#endif
