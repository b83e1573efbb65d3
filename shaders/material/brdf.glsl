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
  float roughness;  // perceptual; of anisotropic lobes that of isotropic ones with their mean albedo
  float alpha;
  float n_dot_v;
  vec3 f0, f90;     // reflectance of a facet at normal incidence and at grazing angles
  vec3 albedo;      // directional albedo of one bounce, towards the eye
  vec3 multiple;    // directional albedo of all further bounces, towards the eye
  float loss;       // share of white facets' light that the first bounce misses, towards the eye
  float per_mean_loss;  // 1 / (PI * mean loss)
  float layer_loss;     // layer_loss_of() towards the eye; only below sheen or clearcoat
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
  vec3 per_mean_entering;  // 1 / (PI * mean share of light that enters the interface)
  vec3 transmitted;  // colour of thin-walled transmission
  vec3 passed;       // KHR_materials_diffuse_transmission: directional albedo of diffuse light from the far side; 0: none
  Interface body;    // above the diffuse layer
  vec3 body_albedo;
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
// Share of light that a white specular lobe loses below a smooth clearcoat, if the light passes it by passes_layer().
float layer_loss_of(float cosine, float roughness);

// Cosine-weighted means over the hemisphere of the table's values, fitted to quadrature in double precision. Largest
// errors: 3 % of the loss (7e-4), 8e-4, 1e-3, 1 % of the layer's loss. Roughness ends where LEAST_ALPHA does.
float mean_loss(float roughness) {
  const float r = max(roughness, 0.0316228);
  return r * r * r * r / (0.11335 + r * (0.81333 + r * (-0.23237 + r * (0.11499 + r * 0.88153))));
}
float mean_grazing_albedo(float r) {
  return 0.04686613 + r * (0.04323477 + r * (-0.42197604 + r * (0.56085293 - r * 0.22655198)));
}
float mean_sheen_albedo(float roughness) {
  const float r = max(roughness, 0.0707107);
  return -0.007158 + r * (0.252911 + r * (-0.090928 + r * (0.590679 - r * 0.448501)));
}
float mean_layer_loss(float roughness) {
  const float r = max(roughness, 0.0316228);
  return r * r / (3.389786 + r * (-2.252575 + r * (28.954348 + r * (-24.115733 + r * 40.077124))));
}

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

// split_albedo() of an anisotropic lobe: that of isotropic facets whose alpha lies between both, at the angle of equal
// masking; the grazing part takes an alpha of its own. Fitted to quadrature: docs/design/materials.md.
vec2 anisotropic_split(Lobe lobe, vec3 direction, float cosine) {
  const float along = dot(lobe.tangent, direction), across = dot(lobe.bitangent, direction);
  const float cosine2 = max(cosine * cosine, 1e-8), along2 = along * along, across2 = across * across;
  const float t2 = lobe.alpha_t * lobe.alpha_t, b2 = lobe.alpha * lobe.alpha, masked2 = b2 * across2;
  const float less = 1 - lobe.alpha_t, masked = masked2 / (cosine2 + masked2);
  const float share = 0.574 - 0.119 * lobe.alpha_t - 0.409 * less * along2 + masked * (0.123 + 0.233 * less);
  const float alpha2 = mix(b2, t2, clamp(share, 0, 1));
  const vec2 split = split_albedo(inversesqrt(1 + (t2 * along2 + masked2) / (alpha2 * cosine2)), sqrt(sqrt(alpha2)));
  const float sideways = across2 / max(along2 + across2, 1e-8);
  const float grazing_share = mix(1, lobe.alpha_t * (0.001 + 0.0789 * cosine), sideways);
  const float albedo = split.x + split.y;
  const float grazing = min(split_albedo(cosine, sqrt(sqrt(mix(b2, t2, grazing_share)))).y, albedo);
  return vec2(albedo - grazing, grazing);
}

// Directional albedo of one bounce, as split_albedo().
vec2 lobe_split(Lobe lobe, vec3 direction, float cosine) {
  return is_anisotropic(lobe) ? anisotropic_split(lobe, direction, cosine) : split_albedo(cosine, lobe.roughness);
}

// layer_loss_of() of a lobe, and its mean over the hemisphere. Those of anisotropic lobes are fitted to quadrature.
float lobe_layer_loss(Lobe lobe, vec3 direction, float cosine) {
  const float loss = layer_loss_of(cosine, lobe.roughness);
  if (!is_anisotropic(lobe)) return loss;
  const float across = dot(lobe.bitangent, direction), across4 = across * across * across * across;
  return loss * (1 + (1 - lobe.alpha / lobe.alpha_t) * (5.3 * lobe.alpha_t * across4 * across4 - 0.3));
}
float lobe_mean_layer_loss(Lobe lobe) {
  const float mean = mean_layer_loss(lobe.roughness);
  return is_anisotropic(lobe) ? mean * (1 - (1 - lobe.alpha / lobe.alpha_t) * (0.25 - 0.17 * lobe.alpha_t)) : mean;
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
// Clamped, since the albedo would exceed 1 at grazing angles below a roughness of 0.2; the bound is fitted to an albedo
// of 1.
float visibility_sheen(float n_dot_v, float n_dot_l, float alpha) {
  const float most = min(0.5 + alpha * (2 + 340 * alpha), 1);
  return clamp(1 / ((1 + sheen_lambda(n_dot_v, alpha) + sheen_lambda(n_dot_l, alpha)) * (4 * n_dot_v * n_dot_l)), 0, most);
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
// the light. The minimum suits specular lobes: reciprocal, and never too bright (layer_loss_of()). The
// product suits diffuse lobes: it is exact for them.
struct LayerPass {
  float specular, diffuse;
};
// covariance: of the layer's albedo and the share of light that the diffuse lobe takes, over that share's mean.
LayerPass passes_layer(float weight, float albedo_eye, float albedo_light, float mean_albedo, float covariance) {
  const float eye = 1 - weight * albedo_eye, light = 1 - weight * albedo_light;
  return LayerPass(min(eye, light), eye * light / (1 - weight * (mean_albedo - covariance)));
}

// Cosine-weighted standard deviation over the hemisphere of the table's grazing part and of sheen's albedo; fitted,
// largest errors 5e-3 and 7e-3.
float albedo_deviation(float r) { return 0.1145 / (1 + 15 * r * r * sqrt(r)); }
float sheen_deviation(float r) { return 0.12 - 0.0046 / max(r, 0.0707107); }

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
// A film does not absorb: each colour that it does not reflect enters.
vec3 body_albedo(Surface s, float cosine, vec2 split) {
  const vec3 plain = vec3(interface_albedo(s.body, split));
  if (!has_film(s) || s.film.metal >= 1) return plain;
  const vec3 film = film_albedo(s.film, s.film.dielectric_f0, cosine, s.base.roughness, split);
  return mix(plain, film + s.film.dielectric_multiple * max(1 - split.x - split.y, 0), s.film.weight);
}

// Reflectance of a facet of that interface.
vec3 body_fresnel(Surface s, float cosine) {
  const vec3 plain = vec3(mix(s.body.f0, s.body.f90, schlick_weight(cosine)));
  return has_film(s) ? mix(plain, thin_film(s.film, s.film.dielectric_f0, clamp(cosine, 0, 1)), s.film.weight) : plain;
}

// Colour of light after all bounces on that interface but the first.
vec3 body_multiple(Surface s) {
  return has_film(s) ? mix(vec3(s.body.multiple), s.film.dielectric_multiple, s.film.weight) : vec3(s.body.multiple);
}

// Mean reflectance of the base's facets over the hemisphere.
vec3 mean_fresnel(Surface s) {
  const vec3 plain = s.base.f0 + (s.base.f90 - s.base.f0) / 21;
  if (!has_film(s)) return plain;
  return mix(plain, s.film.dielectric * s.film.dielectric_mean + s.film.metal * s.film.metal_mean, s.film.weight);
}

// Share of a white specular lobe's light that a layer's minimum loses, returned as a diffuse lobe (after Kulla and Conty
// 2017). Factors on that of a smooth clearcoat; sheen's losses differ by a polynomial in the squared cosine, fitted.
float returned_by_sheen(Surface s, float cosine) {
  const float r = max(s.sheen_roughness, 0.0707107), mean_cosine2 = min(0.04 + 0.85 * s.base.roughness, 0.51);
  const float even = min(0.03 + 0.22 / r, 1.1), rise = clamp(11.5 * r - 2.5, -1, 2.4);
  return largest(s.sheen_color) * (even + rise * s.base.n_dot_v * s.base.n_dot_v) * (even + rise * cosine * cosine) /
         (even + rise * mean_cosine2);
}
float returned_by_coat(Surface s) { return s.coat * albedo_deviation(s.coat_lobe.roughness) / albedo_deviation(0); }

// Reflected radiance times the cosine, per unit of irradiance perpendicular to the light's direction. sine:
// of half the angle that the light subtends. is_above: see is_above_surface(); otherwise light is only transmitted.
vec3 reflect_light(Surface s, vec3 to_light, float sine, bool is_above) {
  const float n_dot_l = dot(s.base.normal, to_light);
  const vec3 h = normalize(to_light + s.to_eye);
  const float grazing = schlick_weight(dot(s.to_eye, h));
  const bool has_sheen = largest(s.sheen_color) > 0;
  vec3 specular = vec3(0), diffuse = vec3(0), sheen = vec3(0);
  const float cosine = abs(n_dot_l);
  if (n_dot_l > 0 && is_above) {
    const vec2 split = lobe_split(s.base, to_light, cosine);
    const float loss = max(1 - split.x - split.y, 0);
    const vec3 entering = 1 - body_albedo(s, cosine, split);
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
    const vec3 entering = 1 - body_fresnel(s, dot(s.to_eye, through));
    const vec2 split = lobe_split(s.base, to_light, cosine);
    specular = entering * microfacets(s.base, through, cosine, sine) * s.transmitted;
    diffuse = (1 - body_multiple(s)) * s.base.loss * max(1 - split.x - split.y, 0) * s.base.per_mean_loss * s.transmitted;
  }
  vec3 returned = vec3(0);  // below a smooth clearcoat
  if ((has_sheen || s.coat > 0) && (n_dot_l < 0 || is_above)) {
    const vec3 passed_on = n_dot_l > 0 ? mean_fresnel(s) : (1 - body_multiple(s)) * s.transmitted;
    returned = passed_on * s.base.layer_loss * lobe_layer_loss(s.base, to_light, cosine) /
               (PI * lobe_mean_layer_loss(s.base));
  }
  // Albedos of interface and layers grow towards grazing angles.
  const float body_deviation = (s.body.f90 - s.body.f0) * albedo_deviation(s.base.roughness) * PI * largest(s.per_mean_entering);
  if (has_sheen) {
    const LayerPass below = passes_layer(largest(s.sheen_color), s.sheen_albedo, sheen_albedo_of(cosine, s.sheen_roughness),
                                         mean_sheen_albedo(s.sheen_roughness), body_deviation * sheen_deviation(s.sheen_roughness));
    specular *= below.specular;
    diffuse = diffuse * below.diffuse + returned_by_sheen(s, cosine) * returned;
  }
  vec3 result = cosine * (specular + diffuse + sheen);
  if (s.coat > 0) {
    const float coat_n_dot_l = dot(s.coat_lobe.normal, to_light);
    const vec2 split = split_albedo(abs(coat_n_dot_l), s.coat_lobe.roughness);
    const Interface coat = s.coat_interface;
    const float covariance = (coat.f90 - coat.f0) * albedo_deviation(s.coat_lobe.roughness) * body_deviation;
    const LayerPass below = passes_layer(s.coat, s.coat_lobe.albedo.r + s.coat_lobe.multiple.r,
                                         interface_albedo(coat, split), coat.mean_albedo, covariance);
    result = cosine * (below.specular * (specular + sheen) + below.diffuse * diffuse + returned_by_coat(s) * returned);
    if (coat_n_dot_l > 0 && is_above) {
      result += coat_n_dot_l * s.coat *
                (microfacets(s.coat_lobe, h, coat_n_dot_l, sine) * mix(coat.f0, coat.f90, grazing) +
                 max(1 - split.x - split.y, 0) * s.coat_lobe.per_mean_loss * s.coat_lobe.multiple);
    }
  }
  // Like the diffuse layer, from the far side, which has neither sheen nor coat.
  if (passes_diffuse(s) && n_dot_l < 0) {
    const vec3 entering = 1 - body_albedo(s, cosine, lobe_split(s.base, to_light, cosine));
    result += cosine * entering * s.per_mean_entering * passes_layers(s) * s.passed;
  }
  return result;
}

#endif
