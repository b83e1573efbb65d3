// Importance sampling of the BRDF in brdf.glsl: a mixture of one density per lobe. Microfacet lobes use visible
// normals (Heitz 2018) drawn as spherical caps (Dupuy and Benyoub 2023), all others the cosine. pdf_of() is the
// density of the whole mixture, so that reflect_light() / pdf_of() is unbiased for every direction.
#ifndef FIRE3DV_BRDF_SAMPLING_GLSL
#define FIRE3DV_BRDF_SAMPLING_GLSL
#include "common/directions.glsl"
#include "material/brdf.glsl"

// Probabilities of the densities; their sum is 1, or 0 for a black surface.
struct LobeShares {
  float facets, diffuse;            // on the eye's side
  float through, through_diffuse;   // behind a thin wall
  float coat_facets, coat_diffuse;  // about the clearcoat's normal
};

// Albedo of sheen, and of what the layers' minimum loses.
float returned_albedo(Surface s) {
  const bool has_sheen = largest(s.sheen_color) > 0;
  float albedo = has_sheen ? largest(s.sheen_color) * s.sheen_albedo : 0;
  if (has_sheen || s.coat > 0) {
    const float returned = (has_sheen ? largest(s.sheen_color) : 0) + (s.coat > 0 ? returned_by_coat(s) : 0);
    albedo += returned * s.base.layer_loss * largest(mean_fresnel(s));
  }
  return albedo;
}

LobeShares lobe_shares(Surface s) {
  LobeShares shares;
  shares.facets = largest(s.base.albedo);
  shares.diffuse = largest(s.diffuse + s.base.multiple) + returned_albedo(s);
  shares.through = largest(s.transmitted * (1 - s.body_albedo));
  shares.through_diffuse = largest(s.transmitted * (1 - body_multiple(s))) * s.base.loss;
  shares.coat_facets = s.coat > 0 ? s.coat * s.coat_lobe.albedo.r : 0;
  shares.coat_diffuse = s.coat > 0 ? s.coat * s.coat_lobe.multiple.r : 0;
  const float sum = shares.facets + shares.diffuse + shares.through + shares.through_diffuse + shares.coat_facets +
                    shares.coat_diffuse;
  const float scale = sum > 0 ? 1 / sum : 0;
  shares.facets *= scale;
  shares.diffuse *= scale;
  shares.through *= scale;
  shares.through_diffuse *= scale;
  shares.coat_facets *= scale;
  shares.coat_diffuse *= scale;
  return shares;
}

// Share of sampled directions for diffuse transmission, beside those of lobe_shares().
float passed_share(Surface s) {
  if (!passes_diffuse(s)) return 0;
  const float passed = largest(s.passed);
  return passed / (passed + largest(s.base.albedo + s.base.multiple + s.diffuse + s.transmitted));
}

// Eye direction for visible normals. A normal map may turn the normal away from the eye; the density then is that
// of a grazing view, which is positive wherever the BRDF is.
vec3 eye_above(vec3 to_eye, vec3 normal) {
  const float cosine = dot(to_eye, normal);
  return cosine >= 1e-4 ? to_eye : normalize(to_eye + (1e-4 - cosine) * normal);
}

// Mirror direction in a visible normal of the lobe.
vec3 sample_facets(Lobe lobe, vec3 to_eye, vec2 u) {
  const bool anisotropic = is_anisotropic(lobe);
  const mat3 world_from_local =
      anisotropic ? mat3(lobe.tangent, lobe.bitangent, lobe.normal) : frame_around(lobe.normal);
  const vec2 alpha = anisotropic ? vec2(lobe.alpha_t, lobe.alpha) : vec2(lobe.alpha);
  const vec3 eye = eye_above(to_eye, lobe.normal);
  const vec3 local = eye * world_from_local;
  const vec3 stretched = normalize(vec3(alpha * local.xy, local.z));
  const float angle = 2 * PI * u.x;
  const float z = (1 - u.y) * (1 + stretched.z) - stretched.z;
  const float sine = sqrt(clamp(1 - z * z, 0, 1));
  const vec3 cap = vec3(sine * cos(angle), sine * sin(angle), z) + stretched;
  const vec3 half_vector = world_from_local * normalize(vec3(alpha * cap.xy, max(cap.z, 0)));
  return normalize(reflect(-eye, half_vector));
}

float facets_pdf(Lobe lobe, vec3 to_eye, vec3 direction) {
  const vec3 eye = eye_above(to_eye, lobe.normal);
  const float n_dot_h = dot(lobe.normal, normalize(direction + eye));
  if (!(n_dot_h > 0)) return 0;
  if (is_anisotropic(lobe)) {
    const mat3 world_from_local = mat3(lobe.tangent, lobe.bitangent, lobe.normal);
    const vec3 facet = normalize(direction + eye) * world_from_local, local = eye * world_from_local;
    const vec2 alpha = vec2(lobe.alpha_t, lobe.alpha);
    return distribution_anisotropic(facet, alpha) / (2 * (max(local.z, 1e-4) + stretched_length(local, alpha)));
  }
  const float a2 = lobe.alpha * lobe.alpha, n_dot_v = clamp(dot(lobe.normal, eye), 1e-4, 1);
  return distribution_ggx(min(n_dot_h, 1), lobe.alpha) / (2 * (n_dot_v + sqrt(a2 + (1 - a2) * n_dot_v * n_dot_v)));
}

vec3 sample_cosine(vec3 normal, vec2 u) {
  const float radius = sqrt(u.x), angle = 2 * PI * u.y;
  return normalize(frame_around(normal) * vec3(radius * cos(angle), radius * sin(angle), sqrt(max(1 - u.x, 0))));
}

float cosine_pdf(vec3 normal, vec3 direction) { return max(dot(normal, direction), 0) / PI; }

vec3 mirrored_at(vec3 normal, vec3 direction) { return direction - 2 * dot(normal, direction) * normal; }

// Density per unit of solid angle.
float pdf_of(Surface s, LobeShares shares, vec3 direction) {
  float pdf = shares.diffuse * cosine_pdf(s.base.normal, direction);
  pdf += shares.facets * facets_pdf(s.base, s.to_eye, direction);
  if (shares.through > 0) {
    const vec3 mirrored = mirrored_at(s.base.normal, direction);
    pdf += shares.through * facets_pdf(s.base, s.to_eye, mirrored) +
           shares.through_diffuse * cosine_pdf(s.base.normal, mirrored);
  }
  if (shares.coat_facets > 0) {
    pdf += shares.coat_facets * facets_pdf(s.coat_lobe, s.to_eye, direction) +
           shares.coat_diffuse * cosine_pdf(s.coat_lobe.normal, direction);
  }
  return pdf;
}

// choice, u: random numbers from 0 to 1, without 1.
vec3 sample_direction(Surface s, LobeShares shares, float choice, vec2 u) {
  const bool passes = choice < shares.through + shares.through_diffuse;
  if (passes || (choice -= shares.through + shares.through_diffuse) < shares.facets + shares.diffuse) {
    const bool by_facets = choice < (passes ? shares.through : shares.facets);
    const vec3 direction = by_facets ? sample_facets(s.base, s.to_eye, u) : sample_cosine(s.base.normal, u);
    return passes ? mirrored_at(s.base.normal, direction) : direction;
  }
  choice -= shares.facets + shares.diffuse;
  // Rounding may leave a choice beyond the last lobe.
  if (shares.coat_facets + shares.coat_diffuse == 0) return sample_cosine(s.base.normal, u);
  return choice < shares.coat_facets ? sample_facets(s.coat_lobe, s.to_eye, u) : sample_cosine(s.coat_lobe.normal, u);
}

#endif
