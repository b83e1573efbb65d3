// Ray effect of a surface, and the lobe whose reflection is traced.
#ifndef FIRE3DV_TRACED_LOBE_GLSL
#define FIRE3DV_TRACED_LOBE_GLSL
#include "common/buffers.glsl"
#include "common/halves.glsl"
#include "common/shared_exponent.glsl"
#include "material/brdf.glsl"

struct RayEffect {
  vec3 reflected;  // radiance of the rays that hit a surface; rays without a hit count as black
  float missed;    // share of the lobe that takes the environment instead
  float open;      // share of the hemisphere that is not occluded
  float blur;      // width of the reflection's blur in pixels; 0: a mirror
  bool has_occlusion;
  bool has_refracted;  // a record of refracted light
  bool has_bounced;    // a record of bounced light
  // Of that record, for shading:
  vec3 bounced;  // radiance from other surfaces, which a white diffuse surface reflects
  vec3 sky;      // share of the environment's radiance that the surface gets, by channel
};

// Light that passes a transmissive surface from behind.
struct RefractedLight {
  vec3 radiance;
  float blur;  // width in pixels; 0: a smooth surface
};

// Light of diffuse rays, averaged: see BouncedRecord.
struct BouncedLight {
  vec3 radiance, missed, all;
};

RayEffect no_ray_effect() { return RayEffect(vec3(0), 1, 1, 0, false, false, false, vec3(0), vec3(1)); }

// Perceptual roughness up to which reflections are traced, and from which they are the environment's alone.
const float kTracedRoughness = 0.4, kUntracedRoughness = 0.6;

// A clearcoat is traced instead of a rougher surface below.
bool traces_coat(Surface s) { return s.coat > 0 && s.coat_lobe.roughness <= s.base.roughness; }

Lobe traced_lobe(Surface s) {
  if (traces_coat(s)) return s.coat_lobe;
  return s.base;
}

float traced_share(Lobe lobe) { return 1 - smoothstep(kTracedRoughness, kUntracedRoughness, lobe.roughness); }

bool is_mirror(Lobe lobe) { return lobe.alpha <= LEAST_ALPHA && !is_anisotropic(lobe); }

RayEffectRecord pack_ray_effect(RayEffect effect, vec3 normal_world) {
  const vec3 reflected = min(effect.reflected, vec3(65504));
  return RayEffectRecord(packHalf2x16(reflected.rg), packHalf2x16(vec2(reflected.b, effect.missed)),
                         packHalf2x16(vec2(effect.open, min(effect.blur, 65504))),
                         packSnorm4x8(vec4(normal_world, (effect.has_occlusion ? 0.125 : 0) + (effect.has_refracted ? 0.25 : 0) +
                                                        (effect.has_bounced ? 0.5 : 0))));
}

RayEffect unpack_ray_effect(RayEffectRecord record) {
  const vec2 blue_missed = unpackHalf2x16(record.reflected_b_missed), open_blur = unpackHalf2x16(record.open_blur);
  const uint flags = uint(round(8 * unpackSnorm4x8(record.normal).w));
  return RayEffect(vec3(unpackHalf2x16(record.reflected_rg), blue_missed.x), blue_missed.y, open_blur.x, open_blur.y,
                   (flags & 1) != 0, (flags & 2) != 0, (flags & 4) != 0, vec3(0), vec3(1));
}

uvec2 pack_refracted(RefractedLight light) {
  const vec3 radiance = min(light.radiance, vec3(65504));
  return uvec2(packHalf2x16(radiance.rg), packHalf2x16(vec2(radiance.b, min(light.blur, 65504))));
}

RefractedLight unpack_refracted(uvec2 record) {
  const vec2 blue_blur = unpackHalf2x16(record.y);
  return RefractedLight(vec3(unpackHalf2x16(record.x), blue_blur.x), blue_blur.y);
}

// Records of refracted light, behind those of all other effects.
uint64_t refracted_records(GlobalsRef globals, uint64_t records) {
  return records + uint64_t(globals.value.width) * globals.value.height * FIRE3DV_SAMPLES * 16;
}

// Records of bounced light, behind those.
uint64_t bounced_records(GlobalsRef globals, uint64_t records, bool has_refracted) {
  return refracted_records(globals, records) +
         (has_refracted ? uint64_t(globals.value.width) * globals.value.height * FIRE3DV_SAMPLES * 8 : 0);
}

BouncedRecord pack_bounced(BouncedLight light) {
  const uvec2 radiance = pack_halves(min(light.radiance, vec3(65504)), 0);
  return BouncedRecord(radiance.x, radiance.y, pack_rgb9e5(light.missed), pack_rgb9e5(light.all));
}

BouncedLight unpack_bounced(BouncedRecord record) {
  return BouncedLight(vec3(unpackHalf2x16(record.radiance_rg), unpackHalf2x16(record.radiance_b).x),
                      unpack_rgb9e5(record.missed), unpack_rgb9e5(record.all));
}

vec3 normal_of_record(RayEffectRecord record) { return normalize(unpackSnorm4x8(record.normal).xyz); }

#endif
