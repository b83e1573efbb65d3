// Ray effects of visible surfaces: mirror and glossy reflections, refraction, one diffuse bounce, and ambient
// occlusion. Rays end at the first opaque surface. All surfaces are shaded by the raster's material model (shading.glsl):
// lamps with shadow rays, and the environment.
//
// Sample patterns depend on the pixel alone: 16 pixels of a block of 4 x 4 share one sequence, so that shading can
// average the block (ray_effect_lookup.glsl). The including shader traces rays: closest_hit() and is_shadowed().
#ifndef FIRE3DV_RAY_EFFECTS_GLSL
#define FIRE3DV_RAY_EFFECTS_GLSL
#define FIRE3DV_LIGHT_OF_HIT
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
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer BouncedOut { BouncedRecord at[]; };

Hit closest_hit(vec3 origin, vec3 direction, float distance_m, bool meets_all);

const float kFar = 1e30;

layout(constant_id = FIRE3DV_VARIANT_BOUNCES) const bool kBounces = true;

uint traced_pixel;

#include "ray_effects/hit_light.glsl"
#include "ray_effects/radiance_through.glsl"

// Index of the pixel's point k in the sequences of its block, from 1. count: points of a pixel.
float sample_index(uvec2 pixel, uint k, uint count) {
  const uint in_block = (pixel.x & 3) + 4 * (pixel.y & 3);
  // Neighbours get parts of the sequence that are far apart.
  const uint part = (in_block * 7) & 15;
  return float(part * count + k + 1);
}

// Point of the R2 sequence (Roberts 2018), from 0 to 1.
vec2 sample_point(uvec2 pixel, uint k, uint count) {
  return fract(0.5 + sample_index(pixel, k, count) * vec2(0.7548776662, 0.5698402910));
}

// Point of the R3 sequence: choices at the end of the ray of that point.
vec3 sample_choices(uvec2 pixel, uint k, uint count) {
  return fract(0.5 + sample_index(pixel, k, count) * vec3(0.8191725134, 0.6710436067, 0.5497004779));
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

// Light of the pixel's diffuse rays, summed.
struct DiffuseRays {
  BouncedLight light;
  float count, nearby;  // nearby: hits within the distance of ambient occlusion
};

// Part of the environment's diffuse light that the surface reflects; see reflect_environment().
float diffuse_weight(Surface s) {
  float weight = largest(s.diffuse + s.base.multiple);
  if (largest(s.sheen_color) > 0) weight += largest(s.sheen_color) * s.sheen_albedo;
  return s.coat > 0 ? weight + s.coat * s.coat_lobe.multiple.r : weight;
}

const float kLeastDiffuse = 1.0 / 256;  // smooth metals have less, and trace no diffuse rays

// Roughness of a lobe as wide as a ray's share of the diffuse lobe of a block.
float diffuse_ray_roughness() { return pow(16.0 * float(push.bounce_rays), -0.25); }

void set_bounced(DiffuseRays rays, inout RayEffect effect, out BouncedLight light) {
  const float scale = 1 / max(rays.count, 1);
  light = BouncedLight(scale * rays.light.radiance, scale * rays.light.missed, scale * rays.light.all);
  effect.has_bounced = rays.count > 0;
  if (!effect.has_bounced || (push.effects & FIRE3DV_RAY_EFFECT_OCCLUSION) == 0) return;
  effect.open = 1 - scale * rays.nearby;
  effect.has_occlusion = true;
}

// One loop for reflected, refracted and diffuse rays, so that the material model occurs once in the code.
void trace_lobes(GlobalsRef globals, MaterialRecord material, Surface surface, SurfacePoint point, uvec2 pixel,
                 inout RayEffect effect, inout RefractedLight refracted, out BouncedLight bounced) {
  const Lobe lobe = traced_lobe(surface);
  const float share = (push.effects & FIRE3DV_RAY_EFFECT_REFLECTIONS) != 0 ? traced_share(lobe) : 0;
  const uint reflected_rays = share <= 0 ? 0 : is_mirror(lobe) ? 1 : push.reflection_rays;
  const bool transmits = kExtensions && (push.effects & FIRE3DV_RAY_EFFECT_REFRACTION) != 0 && largest(surface.transmitted) > 0;
  const bool bends = transmits && is_volume(material);
  // A dispersive volume has rays of their own for each colour.
  const uint colors = bends && is_dispersive(material) ? 3 : 1;
  const uint refracted_rays = !transmits ? 0 : colors * (is_mirror(surface.base) ? 1 : push.reflection_rays);
  const bool scatters = kBounces && diffuse_weight(surface) >= kLeastDiffuse;
  const uint first_diffuse = reflected_rays + refracted_rays, diffuse_rays = scatters ? push.bounce_rays : 0;
  const vec3 plane = point.plane_normal_world, eye = globals.value.eye_world;
  const float eye_distance_m = distance(eye, point.position_world);
  LobeRadiance mirrored = LobeRadiance(vec3(0), 0, 0, 0), passed = LobeRadiance(vec3(0), 0, 0, 0);
  DiffuseRays diffuse = DiffuseRays(BouncedLight(vec3(0), vec3(0), vec3(0)), 0, 0);
  for (uint k = 0; k < first_diffuse + diffuse_rays; ++k) {
    const bool reflects = k < reflected_rays, is_diffuse = kBounces && k >= first_diffuse, passes = !reflects && !is_diffuse;
    const uint first = reflects ? 0 : is_diffuse ? first_diffuse : reflected_rays;
    const uint count = reflects ? reflected_rays : is_diffuse ? diffuse_rays : refracted_rays;
    const uint rays_of_point = passes ? colors : 1;
    const uint point_index = (k - first) / rays_of_point, points = count / rays_of_point;
    ray_channel = rays_of_point > 1 ? 1 + (k - first) % 3 : 0;
    const vec2 u = sample_point(pixel, point_index, points);
    Lobe by = surface.base;
    if (reflects) by = lobe;
    vec3 direction;
    float roughness = by.roughness;
    if (is_diffuse) {
      direction = sample_cosine(point.normal_world, u);
      roughness = diffuse_ray_roughness();
    } else {
      direction = is_mirror(by) ? reflect(-surface.to_eye, by.normal) : sample_facets(by, surface.to_eye, u);
    }
    if (bends && passes) {
      const float ior = medium_ior(globals, point.material, ray_channel);
      direction = normalize(refract(-surface.to_eye, normalize(direction + surface.to_eye), 1 / ior));
    } else if (passes) {
      direction = mirrored_at(by.normal, direction);
    }
    if (reflects) mirrored.count += 1;
    // Directions on the wrong side of the triangle: reflections take the environment, other lobes have fewer rays.
    if ((dot(direction, plane) > 0) == passes) continue;
    const vec3 origin = offset_from_surface(point.position_world, passes ? -plane : plane, eye, point.pixel_size_m,
                                            passes ? 0 : point.lift_m);
    const uvec4 outside = uvec4(FIRE3DV_NO_INDEX);
    takes_one_ray = is_diffuse;
    hit_choices = sample_choices(pixel, point_index, points);
    // Diffuse rays meet what shadow rays meet.
    const bool meets_all = !is_diffuse && (push.effects & FIRE3DV_RAY_EFFECT_REFRACTION) != 0;
    float distance_m;
    const vec3 radiance =
        radiance_through(globals, origin, direction, bends && passes ? media_behind(outside, point.material, false) : outside,
                         eye_distance_m, roughness, meets_all, distance_m);
    const bool hits = distance_m < kFar;
    if (is_diffuse) {
      const vec3 environment = reflected_radiance(globals, direction, roughness);
      diffuse.light.radiance += hits ? radiance : vec3(0);
      diffuse.light.missed += hits ? vec3(0) : environment;
      diffuse.light.all += environment;
      diffuse.count += 1;
      diffuse.nearby += distance_m < push.occlusion_distance_m ? 1 : 0;
      continue;
    }
    const float away = hits ? distance_m / (distance_m + eye_distance_m) : 1;
    if (passes) {
      const vec3 color = ray_channel == 0 ? vec3(1) : 3 * vec3(ray_channel == 1, ray_channel == 2, ray_channel == 3);
      passed = LobeRadiance(passed.sum + color * radiance, passed.count + 1, 0, passed.away + away);
      continue;
    }
    mirrored.away += away;
    if (hits) mirrored = LobeRadiance(mirrored.sum + radiance, mirrored.count, mirrored.hits + 1, mirrored.away);
  }
  mirrored = averaged(mirrored);
  effect.reflected = share * mirrored.sum;
  effect.missed = 1 - share * mirrored.hits;
  effect.blur = blur_of(lobe, mirrored.away);
  passed = averaged(passed);
  refracted = RefractedLight(passed.sum, blur_of(surface.base, passed.away));
  set_bounced(diffuse, effect, bounced);
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
  BouncedLight bounced = BouncedLight(vec3(0), vec3(0), vec3(0));
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) == 0) {
    const uint lobes = FIRE3DV_RAY_EFFECT_REFLECTIONS | FIRE3DV_RAY_EFFECT_REFRACTION | FIRE3DV_RAY_EFFECT_BOUNCE;
    if ((push.effects & lobes) != 0) {
      const vec3 to_eye = normalize(globals.value.eye_world - point.position_world);
      const Surface surface = make_surface(globals, material, surface_base_color(material, point), point, to_eye);
      trace_lobes(globals, material, surface, point, pixel, effect, refracted, bounced);
    }
    if ((push.effects & FIRE3DV_RAY_EFFECT_OCCLUSION) != 0 && !effect.has_occlusion)
      trace_occlusion(point, pixel, effect);
  }
  const uint index = traced_pixel * FIRE3DV_SAMPLES + first;
  effect.has_refracted = kExtensions && (push.effects & FIRE3DV_RAY_EFFECT_REFRACTION) != 0;
  RayEffectOut(push.records).at[index] = pack_ray_effect(effect, point.normal_world);
  if (effect.has_refracted)
    RefractedOut(refracted_records(globals, push.records)).at[index] = pack_refracted(refracted);
  if (effect.has_bounced)
    BouncedOut(bounced_records(globals, push.records, effect.has_refracted)).at[index] = pack_bounced(bounced);
}

#endif
