// BRDF of glTF 2.0 (appendix B) with KHR_materials_ior, specular, clearcoat, sheen and thin-walled
// transmission. Microfacets: GGX (Walter et al. 2007), height-correlated Smith shadowing (Heitz 2014),
// Schlick's Fresnel term (1994). Sheen: Charlie (Estevez and Kulla 2017).
#ifndef FIRE3DV_BRDF_GLSL
#define FIRE3DV_BRDF_GLSL

const float PI = 3.14159265358979;
const float LEAST_ALPHA = 1e-3;        // smaller lobes exceed 32-bit float precision
const float LEAST_SHEEN_ALPHA = 5e-3;

// A microfacet lobe with its response to a uniform environment.
struct Lobe {
  vec3 normal;
  float roughness;  // perceptual
  float alpha;
  float n_dot_v;
  vec3 f0, f90;     // reflectance at normal incidence and at grazing angles, with multiple bounces
  vec3 albedo;      // directional albedo: reflected share of a uniform environment
};

struct Surface {
  vec3 to_eye;       // unit
  vec3 diffuse;      // diffuse albedo below the specular interface; 0 for metals
  vec3 transmitted;  // colour of thin-walled transmission
  float body_f0, body_f90, body_albedo;  // specular reflectance of the interface above the diffuse layer
  Lobe base;
  vec3 sheen_color;  // 0: none
  float sheen_alpha;
  float sheen_albedo;
  float coat;        // clearcoat weight; 0: none
  Lobe coat_lobe;
};

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

float schlick_weight(float cos_theta) {
  const float x = clamp(1 - cos_theta, 0, 1);
  return x * x * x * x * x;
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
  const float widened = min(sqrt(lobe.alpha * lobe.alpha + sine * sine / 8), 1);
  return distribution_ggx(n_dot_h, widened) * visibility_smith(lobe.n_dot_v, n_dot_l, lobe.alpha);
}

// Reflected radiance times the cosine, per unit of irradiance perpendicular to the light's direction. sine:
// of half the angle that the light subtends.
vec3 reflect_light(Surface s, vec3 to_light, float sine) {
  const float n_dot_l = dot(s.base.normal, to_light);
  const vec3 h = normalize(to_light + s.to_eye);
  const float grazing = schlick_weight(dot(s.to_eye, h));
  vec3 result = vec3(0);
  if (n_dot_l > 0) {
    const float entering = 1 - mix(s.body_f0, s.body_f90, grazing);
    result = n_dot_l * (mix(s.base.f0, s.base.f90, grazing) * microfacets(s.base, h, n_dot_l, sine) + entering / PI * s.diffuse);
    if (largest(s.sheen_color) > 0) {
      const float n_dot_h = clamp(dot(s.base.normal, h), 0, 1);
      result *= 1 - largest(s.sheen_color) * s.sheen_albedo;
      result += n_dot_l * distribution_charlie(n_dot_h, s.sheen_alpha) *
                visibility_sheen(s.base.n_dot_v, n_dot_l, s.sheen_alpha) * s.sheen_color;
    }
  } else if (largest(s.transmitted) > 0 && n_dot_l < 0) {
    // Transmission through a thin wall without refraction: the light is mirrored to this side.
    const vec3 through = normalize(to_light - 2 * n_dot_l * s.base.normal + s.to_eye);
    const float entering = 1 - mix(s.body_f0, s.body_f90, schlick_weight(dot(s.to_eye, through)));
    result = -n_dot_l * entering * microfacets(s.base, through, -n_dot_l, sine) * s.transmitted;
  }
  if (s.coat > 0) {
    result *= 1 - s.coat * s.coat_lobe.albedo.r;
    const float coat_n_dot_l = dot(s.coat_lobe.normal, to_light);
    if (coat_n_dot_l > 0) {
      result += coat_n_dot_l * s.coat * microfacets(s.coat_lobe, h, coat_n_dot_l, sine) *
                mix(s.coat_lobe.f0, s.coat_lobe.f90, grazing);
    }
  }
  return result;
}

#endif
