// Image-based lighting: lookups into the environment maps that environment_*.comp prefilters.
#ifndef FIRE3DV_ENVIRONMENT_GLSL
#define FIRE3DV_ENVIRONMENT_GLSL
#include "material/brdf.glsl"
#include "common/buffers.glsl"
#include "common/directions.glsl"
#include "common/textures.glsl"
#include "shared/bindings.h"

layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_BACKGROUND) uniform sampler2D environment_background;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_SPECULAR) uniform samplerCube environment_specular;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_IRRADIANCE) uniform samplerCube environment_irradiance;
layout(set = 0, binding = FIRE3DV_BINDING_ENVIRONMENT_ALBEDO) uniform sampler2D environment_albedo;

// --environment-rotation rotates the environment about +Y, counter-clockwise seen from above; lookups rotate
// back.
vec3 environment_from_world(GlobalsRef globals, vec3 direction) {
  const float c = globals.value.environment_turn.x, s = globals.value.environment_turn.y;
  return vec3(c * direction.x - s * direction.z, direction.y, s * direction.x + c * direction.z);
}

// Prefiltered radiance; the mapping from roughness to level is the inverse of environment.cpp's.
vec3 reflected_radiance(GlobalsRef globals, vec3 direction, float roughness) {
  const float level = roughness * (2 - roughness) * float(textureQueryLevels(environment_specular) - 1);
  return globals.value.environment_intensity *
         textureLod(environment_specular, environment_from_world(globals, direction), level).rgb;
}

// Radiance of a white diffuse surface.
vec3 scattered_radiance(GlobalsRef globals, vec3 normal) {
  return globals.value.environment_intensity *
         textureLod(environment_irradiance, environment_from_world(globals, normal), 0).rgb;
}

// Background radiance of pixels without geometry. Colours instead of the environment are display-referred.
bool is_background_display_referred(GlobalsRef globals) { return globals.value.background_lod < 0; }

vec3 background_radiance(GlobalsRef globals, vec3 direction) {
  if (is_background_display_referred(globals)) {
    if (globals.value.sky_texture != FIRE3DV_NO_INDEX) {
      const vec2 uv = equirectangular_uv(normalize(direction));
      return textureLod(scene_textures[globals.value.sky_texture], uv, globals.value.sky_lod).rgb;
    }
    const float up = direction.y / max(length(direction), 1e-20);
    return mix(globals.value.background, globals.value.background_zenith, smoothstep(-0.55, 0.45, up));
  }
  const vec2 uv = equirectangular_uv(normalize(environment_from_world(globals, direction)));
  return globals.value.environment_intensity * textureLod(environment_background, uv, globals.value.background_lod).rgb;
}

// Coordinates of the lookup table, whose outermost texels are at 0 and 1. Albedos are steep at grazing angles: the table
// has equal steps of the cosine's root.
vec2 albedo_texel(float cosine, float roughness) {
  const float side = FIRE3DV_ENVIRONMENT_ALBEDO_SIDE;
  return vec2(sqrt(max(cosine, 0)), roughness) * ((side - 1) / side) + 0.5 / side;
}

vec2 split_albedo(float cosine, float roughness) {
  const vec2 loss_grazing = textureLod(environment_albedo, albedo_texel(cosine, roughness), 0).rg;
  return vec2(1 - loss_grazing.r - loss_grazing.g, loss_grazing.g);
}

float layer_loss_of(float cosine, float roughness) {
  return textureLod(environment_albedo, albedo_texel(cosine, roughness), 0).a;
}

float sheen_albedo_of(float cosine, float roughness) {
  return textureLod(environment_albedo, albedo_texel(cosine, roughness), 0).b;
}

// An isotropic lobe without reflectances.
Lobe make_facets(vec3 normal, vec3 to_eye, float roughness) {
  Lobe lobe;
  lobe.normal = normal;
  lobe.roughness = clamp(roughness, 0, 1);
  lobe.alpha = max(lobe.roughness * lobe.roughness, LEAST_ALPHA);
  lobe.n_dot_v = clamp(dot(normal, to_eye), 1e-4, 1);
  lobe.alpha_t = lobe.alpha;
  return lobe;
}

// Makes a lobe anisotropic. tangent: unit, perpendicular to the normal; highlights are stretched along it.
void stretch(inout Lobe lobe, vec3 to_eye, vec3 tangent, float strength) {
  lobe.alpha_t = mix(lobe.alpha, 1, strength * strength);
  lobe.tangent = tangent;
  lobe.bitangent = cross(lobe.normal, tangent);
  lobe.eye_along = vec2(dot(tangent, to_eye), dot(lobe.bitangent, to_eye));
  // Fitted to the mean loss over the hemisphere.
  const float share = 0.457 + 0.011 * lobe.alpha_t;
  lobe.roughness = pow(mix(lobe.alpha * lobe.alpha, lobe.alpha_t * lobe.alpha_t, share), 0.25);
}

// Mixes the reflectances of a dielectric and of a metal, whose f90 is 1.
void add_reflectance(inout Lobe lobe, vec3 to_eye, vec3 f0, float f90, vec3 metal_f0, float metallic) {
  const vec2 split = lobe_split(lobe, to_eye, lobe.n_dot_v);
  const float mean = mean_loss(lobe.roughness);
  lobe.loss = max(1 - split.x - split.y, 0);
  lobe.per_mean_loss = 1 / (PI * mean);
  lobe.f0 = mix(f0, metal_f0, metallic);
  lobe.f90 = vec3(mix(f90, 1, metallic));
  lobe.albedo = lobe.f0 * split.x + lobe.f90 * split.y;
  lobe.multiple = lobe.loss * mix(multiple_scattering(f0, vec3(f90), mean), multiple_scattering(metal_f0, vec3(1), mean), metallic);
}

// Replaces the reflectances of base and interface by those of the film, by its weight. The means over the hemisphere
// are Gauss-Legendre quadratures in the squared cosine. mean_albedo: of the interface.
void add_film(inout Surface surface, inout vec3 mean_albedo) {
  const Film film = surface.film;
  const float roughness = surface.base.roughness;
  const float at[4] = float[4](0.0694318442, 0.3300094782, 0.6699905218, 0.9305681558);
  const float weights[4] = float[4](0.1739274226, 0.3260725774, 0.3260725774, 0.1739274226);
  vec3 dielectric = vec3(0), metal = vec3(0), dielectric_once = vec3(0);  // reflectances, albedo of one bounce
  for (int i = 0; i < 4; ++i) {
    const float cosine = sqrt(at[i]);
    if (film.dielectric > 0) {
      const vec2 split = split_albedo(cosine, roughness);
      dielectric += weights[i] * thin_film(film, film.dielectric_f0, cosine);
      dielectric_once += weights[i] * film_albedo(film, film.dielectric_f0, cosine, roughness, split);
    }
    if (film.metal > 0) metal += weights[i] * thin_film(film, film.metal_f0, cosine);
  }
  const float loss = mean_loss(roughness);
  const vec2 split = lobe_split(surface.base, surface.to_eye, surface.base.n_dot_v);
  const vec3 once = film_albedo(film, surface.base.n_dot_v, roughness, split);
  surface.film.dielectric_mean = dielectric;
  surface.film.metal_mean = metal;
  surface.film.dielectric_multiple = multiple_scattering(dielectric, dielectric, loss);
  const vec3 multiple =
      film.dielectric * surface.film.dielectric_multiple + film.metal * multiple_scattering(metal, metal, loss);
  surface.base.albedo = mix(surface.base.albedo, once, film.weight);
  surface.base.multiple = mix(surface.base.multiple, surface.base.loss * multiple, film.weight);
  mean_albedo = mix(mean_albedo, dielectric_once + surface.film.dielectric_multiple * loss, film.weight);
}

// The interface above the diffuse layer: the share of light that enters it weighs the layer.
void add_body(inout Surface surface, float f0, float f90) {
  const Lobe lobe = surface.base;
  surface.body = make_interface(f0, f90, lobe.roughness);
  vec3 mean_albedo = vec3(surface.body.mean_albedo);
  if (has_film(surface)) add_film(surface, mean_albedo);
  surface.body_albedo = body_albedo(surface, lobe.n_dot_v, lobe_split(lobe, surface.to_eye, lobe.n_dot_v));
  surface.per_mean_entering = 1 / (PI * max(1 - mean_albedo, 1e-3));
  surface.diffuse *= 1 - surface.body_albedo;
}

// Radiance from the environment, averaged over an anisotropic lobe: prefiltered look-ups along the tangent, at
// quantiles of the slopes of GGX, each weighted as visible facets are (Heitz 2018).
vec3 stretched_radiance(GlobalsRef globals, Lobe lobe, vec3 to_eye) {
  const uint kTaps = 16;
  const vec2 alpha = vec2(lobe.alpha_t, lobe.alpha);
  const vec3 eye = vec3(lobe.eye_along, lobe.n_dot_v);
  // Each look-up spans the bitangent's roughness in both directions, and at least the distance of its neighbours.
  const float slope_scale = sqrt(alpha.x * alpha.x - alpha.y * alpha.y);
  const float roughness = sqrt(min(max(alpha.y, alpha.x / kTaps), 1));
  vec3 sum = vec3(0);
  float weights = 0;
  for (uint i = 0; i < kTaps; ++i) {
    const float u = (2 * i + 1.0) / kTaps - 1;
    const float slope = slope_scale * u * inversesqrt(1 - u * u);
    const vec3 facet = normalize(vec3(slope, 0, 1));
    const float e_dot_f = dot(eye, facet);
    const vec3 light = 2 * e_dot_f * facet - eye;
    if (e_dot_f <= 0 || light.z <= 0) continue;
    const float weight = e_dot_f / facet.z * light.z * visibility_anisotropic(eye, light, alpha);
    const vec3 direction = light.x * lobe.tangent + light.y * lobe.bitangent + light.z * lobe.normal;
    sum += weight * reflected_radiance(globals, direction, roughness);
    weights += weight;
  }
  return weights > 0 ? sum / weights : reflected_radiance(globals, reflect(-to_eye, lobe.normal), lobe.roughness);
}

// scattered: radiance of a white diffuse surface at the same point. open: share of the mirrored environment.
vec3 reflect_environment_lobe(GlobalsRef globals, Lobe lobe, vec3 to_eye, vec3 scattered, float open) {
  if (is_anisotropic(lobe))
    return lobe.albedo * (open * stretched_radiance(globals, lobe, to_eye)) + lobe.multiple * scattered;
  return lobe.albedo * (open * reflected_radiance(globals, reflect(-to_eye, lobe.normal), lobe.roughness)) +
         lobe.multiple * scattered;
}

vec3 reflect_environment(GlobalsRef globals, Surface s, vec3 scattered, float open) {
  vec3 result = reflect_environment_lobe(globals, s.base, s.to_eye, scattered, open) + s.diffuse * scattered;
  if (largest(s.sheen_color) > 0) {
    // The sheen lobe spans a hemisphere, so the diffuse lookup serves it, too.
    result *= 1 - largest(s.sheen_color) * s.sheen_albedo;
    result += s.sheen_color * s.sheen_albedo * scattered;
  }
  if (s.coat > 0) {
    result *= 1 - coat_albedo(s);
    result += s.coat * reflect_environment_lobe(globals, s.coat_lobe, s.to_eye, scattered, open);
  }
  return result;
}

// Diffuse light of the far side's environment that comes through.
vec3 pass_environment(GlobalsRef globals, Surface s) {
  return passes_diffuse(s) ? passes_layers(s) * s.passed * scattered_radiance(globals, -s.base.normal) : vec3(0);
}

vec3 reflect_environment(GlobalsRef globals, Surface s, float occlusion) {
  vec3 result = reflect_environment(globals, s, scattered_radiance(globals, s.base.normal), 1);
  if (kDiffuseTransmission) result += pass_environment(globals, s);
  return result * occlusion;
}

#endif
