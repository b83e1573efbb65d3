// Ray effects as shading reads them: averaged over the 4 x 4 pixels that share a sample pattern, within one part of
// the scene and about one normal.
#ifndef FIRE3DV_RAY_EFFECT_LOOKUP_GLSL
#define FIRE3DV_RAY_EFFECT_LOOKUP_GLSL
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"
#include "environment/environment.glsl"
#include "ray_effects/traced_lobe.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer RayEffectRef { RayEffectRecord at[]; };

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer RefractedRef { uvec2 at[]; };

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BouncedRef { BouncedRecord at[]; };

RayEffect ray_effect;  // of the surface being shaded

// First sample of the pixel that shows the part; 4: none does.
int sample_of_part(GlobalsRef globals, PixelIds ids, uint part) {
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    const uint id = id_of_sample(ids, s);
    if (id != 0 && part_of_id(globals, id) == part) return findLSB(samples_with(ids, id));
  }
  return 4;
}

// samples: of the pixel, that show the surface with the id.
RayEffect ray_effect_at(GlobalsRef globals, uint64_t visibility, uint64_t records, uvec2 pixel, uint id, uint samples) {
  RayEffectRef effects = RayEffectRef(records);
  const uint own_index = (pixel.y * globals.value.width + pixel.x) * FIRE3DV_SAMPLES + findLSB(samples);
  const RayEffectRecord own = effects.at[own_index];
  RayEffect effect = unpack_ray_effect(own);
  const float blend = clamp(effect.blur - 1, 0, 1);  // narrow blurs keep the pixel's own rays
  if (blend <= 0 && !effect.has_occlusion && !effect.has_bounced) return effect;
  const vec3 normal = normal_of_record(own);
  const uint part = part_of_id(globals, id);
  float open_sum = effect.open, opens = 1, weights = 1;
  vec4 sum = vec4(effect.reflected, effect.missed);
  BouncedRef bounced = BouncedRef(bounced_records(globals, records, effect.has_refracted));
  BouncedLight light = BouncedLight(vec3(0), vec3(0), vec3(0));
  if (effect.has_bounced) light = unpack_bounced(bounced.at[own_index]);
  float lights = 1;
  for (int i = 0; i < 16; ++i) {
    const ivec2 neighbour = ivec2(pixel) + ivec2(i & 3, i >> 2) - 1;
    const bool is_inside = neighbour.x >= 0 && neighbour.y >= 0 && neighbour.x < int(globals.value.width) && neighbour.y < int(globals.value.height);
    if (neighbour == ivec2(pixel) || !is_inside) continue;
    const uint index = uint(neighbour.y) * globals.value.width + uint(neighbour.x);
    const int s = sample_of_part(globals, pixel_ids(globals, visibility, index), part);
    if (s == 4) continue;
    const RayEffectRecord record = effects.at[index * FIRE3DV_SAMPLES + s];
    if (dot(normal, normal_of_record(record)) < 0.9) continue;
    const RayEffect other = unpack_ray_effect(record);
    open_sum += other.open;
    opens += 1;
    const float weight = blend * clamp(other.blur - 1, 0, 1);
    sum += weight * vec4(other.reflected, other.missed);
    weights += weight;
    if (!effect.has_bounced || !other.has_bounced) continue;
    const BouncedLight near = unpack_bounced(bounced.at[index * FIRE3DV_SAMPLES + s]);
    light = BouncedLight(light.radiance + near.radiance, light.missed + near.missed, light.all + near.all);
    lights += 1;
  }
  effect.reflected = sum.rgb / weights;
  effect.missed = sum.a / weights;
  effect.open = open_sum / opens;
  effect.bounced = light.radiance / lights;
  // Relative to all directions of the same pattern: exactly 1 where no ray hits a surface.
  effect.sky = light.missed / max(light.all, vec3(1e-20));
  return effect;
}

// Radiance of a white diffuse surface. The bounce replaces occlusion of the environment.
vec3 scattered_traced(GlobalsRef globals, Surface s, float occlusion, RayEffect effect) {
  const vec3 environment = scattered_radiance(globals, s.base.normal);
  return effect.has_bounced ? effect.bounced + effect.sky * environment : occlusion * environment;
}

// Radiance behind a transmissive surface, averaged likewise.
vec3 refracted_at(GlobalsRef globals, uint64_t visibility, uint64_t records, uvec2 pixel, uint id, uint samples) {
  RayEffectRef effects = RayEffectRef(records);
  RefractedRef lights = RefractedRef(refracted_records(globals, records));
  const uint own_index = (pixel.y * globals.value.width + pixel.x) * FIRE3DV_SAMPLES + findLSB(samples);
  const RefractedLight own = unpack_refracted(lights.at[own_index]);
  const float blend = clamp(own.blur - 1, 0, 1);
  if (blend <= 0) return own.radiance;
  const vec3 normal = normal_of_record(effects.at[own_index]);
  const uint part = part_of_id(globals, id);
  vec3 sum = own.radiance;
  float weights = 1;
  for (int i = 0; i < 16; ++i) {
    const ivec2 neighbour = ivec2(pixel) + ivec2(i & 3, i >> 2) - 1;
    const bool is_inside = neighbour.x >= 0 && neighbour.y >= 0 && neighbour.x < int(globals.value.width) && neighbour.y < int(globals.value.height);
    if (neighbour == ivec2(pixel) || !is_inside) continue;
    const uint index = uint(neighbour.y) * globals.value.width + uint(neighbour.x);
    const int s = sample_of_part(globals, pixel_ids(globals, visibility, index), part);
    if (s == 4 || dot(normal, normal_of_record(effects.at[index * FIRE3DV_SAMPLES + s])) < 0.9) continue;
    const RefractedLight other = unpack_refracted(lights.at[index * FIRE3DV_SAMPLES + s]);
    const float weight = blend * clamp(other.blur - 1, 0, 1);
    sum += weight * other.radiance;
    weights += weight;
  }
  return sum / weights;
}

// Change of reflect_environment() by the traced reflection: hits instead of the environment. Exactly zero where no
// ray has hit a surface.
vec3 reflect_traced(GlobalsRef globals, Surface s, float occlusion, RayEffect effect) {
  if (effect.missed >= 1) return vec3(0);
  const Lobe lobe = traced_lobe(s);
  vec3 environment;
  if (is_anisotropic(lobe)) {
    environment = stretched_radiance(globals, lobe, s.to_eye);
  } else {
    environment = reflected_radiance(globals, reflect(-s.to_eye, lobe.normal), lobe.roughness);
  }
  vec3 factor = lobe.albedo;
  if (traces_coat(s)) {
    factor *= s.coat;
  } else {
    if (largest(s.sheen_color) > 0) factor *= 1 - largest(s.sheen_color) * s.sheen_albedo;
    if (s.coat > 0) factor *= 1 - coat_albedo(s);
  }
  return factor * (effect.reflected - (1 - effect.missed) * occlusion * environment);
}

#endif
