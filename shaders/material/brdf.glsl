// BRDF of glTF 2.0 (appendix B) with KHR_materials_ior, specular, clearcoat, sheen, anisotropy, iridescence,
// diffuse transmission and thin-walled transmission. Reciprocal and energy-conserving; lamps and environment share its albedos: docs/design/materials.md.
// Microfacets: GGX (Walter et al. 2007), height-correlated Smith shadowing (Heitz 2014), Schlick's Fresnel term
// (1994). Multiple scattering: Kulla and Conty (2017). Diffuse layer: Kelemen and Szirmay-Kalos (2001). Sheen:
// Charlie (Estevez and Kulla 2017). Anisotropic facets: Burley (2012), Heitz (2014).
#ifndef FIRE3DV_BRDF_GLSL
#define FIRE3DV_BRDF_GLSL
#include "common/scene_variant.glsl"
#include "material/fresnel.glsl"

const float PI = 3.14159265358979;
const float LEAST_ALPHA = 1e-3;        // smaller lobes exceed 32-bit float precision
const float LEAST_SHEEN_ALPHA = 5e-3;

// A microfacet lobe. A ray that leaves the facets after one bounce belongs to the specular lobe, all others to a
// diffuse lobe for multiple scattering.
struct Lobe {
  vec3 normal;
  float roughness;  // perceptual; of anisotropic lobes the cubic mean
  float alpha;
  float n_dot_v;
  vec3 f0, f90;     // reflectance of a facet at normal incidence and at grazing angles
  vec3 albedo;      // directional albedo of one bounce, towards the eye
  vec3 multiple;    // directional albedo of all further bounces, towards the eye
  float loss;       // share of white facets' light that the first bounce misses, towards the eye
  float per_mean_loss;  // 1 / (PI * mean loss)
  // Anisotropic if kAnisotropy and alpha_t != alpha: alpha_t is along the tangent, alpha along the bitangent.
  float alpha_t;
  vec3 tangent, bitangent;
  vec2 eye_along;  // direction to the eye along both
};

bool is_anisotropic(Lobe lobe) { return kAnisotropy && lobe.alpha_t != lobe.alpha; }

// A smooth or rough boundary of a dielectric, achromatic: what it does not reflect enters the layer below.
struct Interface {
  float f0, f90;      // reflectance of a facet
  float multiple;     // colour of light after all bounces but the first
  float mean_albedo;  // over the hemisphere, weighted by the cosine
};

struct Surface {
  vec3 to_eye;       // unit
  vec3 diffuse;      // directional albedo of the diffuse layer below the specular interface; 0 for metals
  float per_mean_entering;  // 1 / (PI * mean share of light that enters the interface)
  vec3 transmitted;  // colour of thin-walled transmission
  vec3 passed;       // KHR_materials_diffuse_transmission: directional albedo of diffuse light from the far side; 0: none
  Interface body;    // above the diffuse layer
  float body_albedo;
  Film film;         // on the base
  Lobe base;
  vec3 sheen_color;  // 0: none
  float sheen_roughness;
  float sheen_alpha;
  float sheen_albedo;
  float coat;        // clearcoat weight; 0: none
  Interface coat_interface;
  Lobe coat_lobe;
};

// Directional albedos by cosine and roughness, from the lookup table of environment_albedo.comp. split_albedo:
// factors of f0 and of f90 for one bounce.
vec2 split_albedo(float cosine, float roughness);
float sheen_albedo_of(float cosine, float roughness);

// Cosine-weighted means over the hemisphere of the table's values: polynomials fitted to quadrature in double
// precision. Largest errors: 1e-4, 8e-4, 4e-3.
float mean_loss(float r) {
  return max(1.26920e-5 + r * (-2.04499e-3 + r * (1.234158e-2 + r * (0.2732153 + r * (3.1026264 + r * (-4.4009070 + r * 1.6057129))))), 1e-3);
}
float mean_grazing_albedo(float r) {
  return 0.04686613 + r * (0.04323477 + r * (-0.42197604 + r * (0.56085293 - r * 0.22655198)));
}
float mean_sheen_albedo(float r) { return 0.01177421 + r * (0.03917436 + r * (0.6509368 - r * 0.4015922)); }

// Colour of light after all bounces but the first, relative to white facets. Mean Fresnel term of Schlick's:
// f0 + (f90 - f0) / 21.
vec3 multiple_scattering(vec3 f0, vec3 f90, float loss) {
  const vec3 mean = f0 + (f90 - f0) / 21;
  return mean * mean * (1 - loss) / (1 - mean * loss);
}

Interface make_interface(float f0, float f90, float roughness) {
  const float mean = mean_loss(roughness), mean_y = mean_grazing_albedo(roughness);
  Interface result;
  result.f0 = f0;
  result.f90 = f90;
  result.multiple = multiple_scattering(vec3(f0), vec3(f90), mean).r;
  result.mean_albedo = f0 * (1 - mean - mean_y) + f90 * mean_y + result.multiple * mean;
  return result;
}

// split: of the table, for the direction and the roughness.
float interface_albedo(Interface of, vec2 split) {
  return of.f0 * split.x + of.f90 * split.y + of.multiple * max(1 - split.x - split.y, 0);
}

float distribution_ggx(float n_dot_h, float alpha) {
  const float a2 = alpha * alpha;
  const float d = n_dot_h * n_dot_h * (a2 - 1) + 1;
  return a2 / (PI * d * d);
}

// Smith shadowing and masking, divided by 4 * n_dot_v * n_dot_l.
float visibility_smith(float n_dot_v, float n_dot_l, float alpha) {
  const float a2 = alpha * alpha;
  return 0.5 / (n_dot_l * sqrt(n_dot_v * n_dot_v * (1 - a2) + a2) + n_dot_v * sqrt(n_dot_l * n_dot_l * (1 - a2) + a2));
}

// Anisotropic distribution and visibility. Arguments: components along tangent and bitangent, and the normal.
float distribution_anisotropic(vec3 facet, vec2 alpha) {
  const vec2 slope = facet.xy / alpha;
  const float d = dot(slope, slope) + facet.z * facet.z;
  return 1 / (PI * alpha.x * alpha.y * d * d);
}
float stretched_length(vec3 direction, vec2 alpha) { return length(vec3(alpha * direction.xy, direction.z)); }
float visibility_anisotropic(vec3 eye, vec3 light, vec2 alpha) {
  return 0.5 / (light.z * stretched_length(eye, alpha) + eye.z * stretched_length(light, alpha));
}

// Directional albedo of one bounce, as split_albedo(). Anisotropic lobes use the table of isotropic ones with the
// cubic mean of the roughnesses, at the angle where the masking is that of the direction: docs/design/materials.md.
vec2 lobe_split(Lobe lobe, vec3 direction, float cosine) {
  const vec2 split = split_albedo(cosine, lobe.roughness);
  if (!is_anisotropic(lobe)) return split;
  const vec2 slope = vec2(lobe.alpha_t * dot(lobe.tangent, direction), lobe.alpha * dot(lobe.bitangent, direction)) /
                     (lobe.roughness * lobe.roughness * max(cosine, 1e-4));
  const vec2 masked = split_albedo(inversesqrt(1 + dot(slope, slope)), lobe.roughness);
  const float albedo = masked.x + masked.y, grazing = min(split.y, albedo);
  return vec2(albedo - grazing, grazing);
}

float distribution_charlie(float n_dot_h, float alpha) {
  const float sin2 = max(1 - n_dot_h * n_dot_h, 1e-7);
  return (2 + 1 / alpha) * pow(sin2, 0.5 / alpha) / (2 * PI);
}

// Fit of the sheen shadowing term by Estevez and Kulla.
float sheen_lambda_fit(float x, float alpha) {
  const float t = (1 - alpha) * (1 - alpha);
  return mix(21.5473, 25.3245, t) / (1 + mix(3.82987, 3.32435, t) * pow(x, mix(0.19823, 0.16801, t))) +
         mix(-1.97760, -1.27393, t) * x + mix(-4.32054, -4.85967, t);
}
float sheen_lambda(float cos_theta, float alpha) {
  if (cos_theta < 0.5) return exp(sheen_lambda_fit(cos_theta, alpha));
  return exp(2 * sheen_lambda_fit(0.5, alpha) - sheen_lambda_fit(1 - cos_theta, alpha));
}
float visibility_sheen(float n_dot_v, float n_dot_l, float alpha) {
  return clamp(1 / ((1 + sheen_lambda(n_dot_v, alpha) + sheen_lambda(n_dot_l, alpha)) * (4 * n_dot_v * n_dot_l)), 0, 1);
}

float largest(vec3 v) { return max(v.r, max(v.g, v.b)); }

// Distribution times visibility. An area light widens the highlight: half vectors to a disk spread by sine^2
// / 16 in each direction, facet slopes by alpha^2 / 2.
float microfacets(Lobe lobe, vec3 half_vector, float n_dot_l, float sine) {
  const float n_dot_h = clamp(dot(lobe.normal, half_vector), 0, 1);
  if (is_anisotropic(lobe)) {
    const vec3 facet = vec3(dot(lobe.tangent, half_vector), dot(lobe.bitangent, half_vector), n_dot_h);
    const vec3 eye = vec3(lobe.eye_along, lobe.n_dot_v);
    const vec3 light = vec3(2 * dot(eye, facet) * facet.xy - eye.xy, n_dot_l);  // mirrored by the facet
    const vec2 alpha = vec2(lobe.alpha_t, lobe.alpha);
    return distribution_anisotropic(facet, min(sqrt(alpha * alpha + sine * sine / 8), 1)) *
           visibility_anisotropic(eye, light, alpha);
  }
  const float widened = min(sqrt(lobe.alpha * lobe.alpha + sine * sine / 8), 1);
  return distribution_ggx(n_dot_h, widened) * visibility_smith(lobe.n_dot_v, n_dot_l, lobe.alpha);
}

// Share of light that passes a layer above a surface, by the layer's weight and its albedo towards the eye and
// the light. The minimum suits specular lobes: reciprocal, and never too bright. The product suits diffuse lobes:
// it is exact for them.
struct LayerPass {
  float specular, diffuse;
};
// covariance: of the layer's albedo and the share of light that the diffuse lobe takes, over that share's mean.
LayerPass passes_layer(float weight, float albedo_eye, float albedo_light, float mean_albedo, float covariance) {
  const float eye = 1 - weight * albedo_eye, light = 1 - weight * albedo_light;
  return LayerPass(min(eye, light), eye * light / (1 - weight * (mean_albedo - covariance)));
}

// Cosine-weighted standard deviation of the table's grazing part over the hemisphere; fitted, largest error 5e-3.
float albedo_deviation(float r) { return 0.1145 / (1 + 15 * r * r * sqrt(r)); }

// Directional albedo of the clearcoat, weighted.
float coat_albedo(Surface s) { return s.coat * (s.coat_lobe.albedo.r + s.coat_lobe.multiple.r); }

// Share of light that passes sheen and clearcoat towards the eye.
float passes_layers(Surface s) {
  float share = 1;
  if (s.coat > 0) share *= max(1 - coat_albedo(s), 0);
  if (largest(s.sheen_color) > 0) share *= max(1 - largest(s.sheen_color) * s.sheen_albedo, 0);
  return share;
}

bool passes_diffuse(Surface s) { return kDiffuseTransmission && largest(s.passed) > 0; }

bool has_film(Surface s) { return kIridescence && s.film.weight > 0; }

// Mean over the visible facets of the cosine between their normal and a direction, by the cosine of the direction:
// fitted to quadrature, largest error 0.02.
float mean_facet_cosine(float cosine, float roughness) {
  const float alpha = roughness * roughness, a = pow(alpha, 1.25);
  const float at_normal = 1 - 0.33 * a / (1 + 2.27 * a), at_grazing = 2.9 * alpha / (1 + 3.26 * alpha);
  const float smooth_ones = sqrt(mix(at_grazing * at_grazing, at_normal * at_normal, cosine * cosine));
  return mix(smooth_ones, mix(at_grazing, at_normal, cosine), clamp(2 * roughness - 1, 0, 1));
}

// Directional albedo of one bounce on facets with a film: its reflectance at their mean cosine, and white by how much
// the mean of Schlick's term exceeds the term there. split: of the lobe, for the direction.
vec3 film_albedo(Film film, vec3 base_f0, float cosine, float roughness, vec2 split) {
  const float facet = mean_facet_cosine(cosine, roughness), grazing = schlick_weight(facet);
  const float mean_grazing = split.y / max(split.x + split.y, 1e-6);
  const float excess = clamp((mean_grazing - grazing) / max(1 - grazing, 1e-6), 0, 1);
  return (split.x + split.y) * mix(thin_film(film, base_f0, facet), vec3(1), excess);
}

// The same of the whole surface.
vec3 film_albedo(Film film, float cosine, float roughness, vec2 split) {
  vec3 result = vec3(0);
  if (film.dielectric > 0) result += film.dielectric * film_albedo(film, film.dielectric_f0, cosine, roughness, split);
  if (film.metal > 0) result += film.metal * film_albedo(film, film.metal_f0, cosine, roughness, split);
  return result;
}

// Directional albedo of the interface above the diffuse layer, by the direction's cosine. split: of the base, for it.
float body_albedo(Surface s, float cosine, vec2 split) {
  float once = s.body.f0 * split.x + s.body.f90 * split.y;
  if (has_film(s) && s.film.metal < 1) {
    const float film = largest(film_albedo(s.film, s.film.dielectric_f0, cosine, s.base.roughness, split));
    once = mix(once, film, s.film.weight);
  }
  return once + s.body.multiple * max(1 - split.x - split.y, 0);
}

// Reflectance of a facet of that interface.
float body_fresnel(Surface s, float cosine) {
  float fresnel = mix(s.body.f0, s.body.f90, schlick_weight(cosine));
  if (has_film(s)) {
    const float film = largest(thin_film(s.film, s.film.dielectric_f0, clamp(cosine, 0, 1)));
    fresnel = mix(fresnel, film, s.film.weight);
  }
  return fresnel;
}

// Reflected radiance times the cosine, per unit of irradiance perpendicular to the light's direction. sine:
// of half the angle that the light subtends.
vec3 reflect_light(Surface s, vec3 to_light, float sine) {
  const float n_dot_l = dot(s.base.normal, to_light);
  const vec3 h = normalize(to_light + s.to_eye);
  const float grazing = schlick_weight(dot(s.to_eye, h));
  const bool has_sheen = largest(s.sheen_color) > 0;
  vec3 specular = vec3(0), diffuse = vec3(0), sheen = vec3(0);
  const float cosine = abs(n_dot_l);
  if (n_dot_l > 0) {
    const vec2 split = lobe_split(s.base, to_light, cosine);
    const float loss = max(1 - split.x - split.y, 0);
    const float entering = 1 - body_albedo(s, cosine, split);
    vec3 fresnel = mix(s.base.f0, s.base.f90, grazing);
    if (has_film(s)) fresnel = mix(fresnel, film_reflectance(s.film, clamp(dot(s.to_eye, h), 0, 1)), s.film.weight);
    specular = fresnel * microfacets(s.base, h, n_dot_l, sine);
    diffuse = loss * s.base.per_mean_loss * s.base.multiple + entering * s.per_mean_entering * s.diffuse;
    if (has_sheen) {
      const float n_dot_h = clamp(dot(s.base.normal, h), 0, 1);
      sheen = distribution_charlie(n_dot_h, s.sheen_alpha) * visibility_sheen(s.base.n_dot_v, n_dot_l, s.sheen_alpha) *
              s.sheen_color;
    }
  } else if (largest(s.transmitted) > 0 && n_dot_l < 0) {
    // Transmission through a thin wall without refraction: the light is mirrored to this side.
    const vec3 through = normalize(to_light - 2 * n_dot_l * s.base.normal + s.to_eye);
    const float entering = 1 - body_fresnel(s, dot(s.to_eye, through));
    const vec2 split = lobe_split(s.base, to_light, cosine);
    specular = entering * microfacets(s.base, through, cosine, sine) * s.transmitted;
    diffuse = (1 - s.body.multiple) * s.base.loss * max(1 - split.x - split.y, 0) * s.base.per_mean_loss * s.transmitted;
  }
  if (has_sheen) {
    const LayerPass below = passes_layer(largest(s.sheen_color), s.sheen_albedo, sheen_albedo_of(cosine, s.sheen_roughness),
                                         mean_sheen_albedo(s.sheen_roughness), 0);
    specular *= below.specular;
    diffuse *= below.diffuse;
  }
  vec3 result = cosine * (specular + diffuse + sheen);
  if (s.coat > 0) {
    const float coat_n_dot_l = dot(s.coat_lobe.normal, to_light);
    const vec2 split = split_albedo(abs(coat_n_dot_l), s.coat_lobe.roughness);
    const Interface coat = s.coat_interface;
    // Both albedos grow towards grazing angles.
    const float covariance = (coat.f90 - coat.f0) * albedo_deviation(s.coat_lobe.roughness) * (s.body.f90 - s.body.f0) *
                             albedo_deviation(s.base.roughness) * PI * s.per_mean_entering;
    const LayerPass below = passes_layer(s.coat, s.coat_lobe.albedo.r + s.coat_lobe.multiple.r,
                                         interface_albedo(coat, split), coat.mean_albedo, covariance);
    result = cosine * (below.specular * (specular + sheen) + below.diffuse * diffuse);
    if (coat_n_dot_l > 0) {
      result += coat_n_dot_l * s.coat *
                (microfacets(s.coat_lobe, h, coat_n_dot_l, sine) * mix(coat.f0, coat.f90, grazing) +
                 max(1 - split.x - split.y, 0) * s.coat_lobe.per_mean_loss * s.coat_lobe.multiple);
    }
  }
  // Like the diffuse layer, from the far side, which has neither sheen nor coat.
  if (passes_diffuse(s) && n_dot_l < 0) {
    const float entering = 1 - body_albedo(s, cosine, lobe_split(s.base, to_light, cosine));
    result += cosine * entering * s.per_mean_entering * passes_layers(s) * s.passed;
  }
  return result;
}

#endif
