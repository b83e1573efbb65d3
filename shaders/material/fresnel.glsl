// Fresnel terms of facets: Schlick's (1994), and thin films after Belcour and Barla (2017) in the form of
// KHR_materials_iridescence: Schlick's terms at both interfaces, real indices, two orders of interference.
#ifndef FIRE3DV_FRESNEL_GLSL
#define FIRE3DV_FRESNEL_GLSL

// Thin film on the facets of a surface that is a dielectric and a metal in parts.
struct Film {
  float weight;  // 0: none
  float ior;     // at least 1
  float thickness_nm;
  float dielectric, metal;       // shares of the surface
  vec3 dielectric_f0, metal_f0;  // of the bases, without the film
  vec3 dielectric_mean, metal_mean;  // reflectances over the hemisphere, with the film
  vec3 dielectric_multiple;      // colour of light after all bounces but the first
};

float schlick_weight(float cos_theta) {
  const float x = clamp(1 - cos_theta, 0, 1);
  return x * x * x * x * x;
}

// Response of the CIE observer to an interference term with this optical path difference, as linear sRGB: the
// observer's curves are Gaussians, whose Fourier transforms are closed (section 4 of the article). The constants are
// those of KHR_materials_iridescence.
vec3 film_sensitivity(float path_nm, vec3 shift) {
  const float two_pi = 6.28318530717959;
  const float phase = two_pi * path_nm * 1e-9;
  const vec3 position = vec3(1.6810e6, 1.7953e6, 2.2084e6), variance = vec3(4.3278e9, 9.3046e9, 6.6121e9);
  vec3 xyz = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13) * sqrt(two_pi * variance) * cos(position * phase + shift) *
             exp(-phase * phase * variance);
  const float second_variance = 4.5282e9;  // second maximum of x
  xyz.x += 9.7470e-14 * sqrt(two_pi * second_variance) * cos(2.2399e6 * phase + shift.r) *
           exp(-phase * phase * second_variance);
  xyz /= 1.0685e-7;
  return mat3(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252) * xyz;
}

// Reflectance of the film above a base, by the cosine in air at which a facet is seen.
vec3 thin_film(Film film, vec3 base_f0, float cosine) {
  const float pi = 3.14159265358979;
  const float inside = sqrt(max(1 - (1 - cosine * cosine) / (film.ior * film.ior), 0));
  const float r0 = (film.ior - 1) / (film.ior + 1);
  const float r12 = mix(r0 * r0, 1, schlick_weight(cosine)), t121 = 1 - r12;
  const vec3 root = sqrt(min(base_f0, 0.9999)), base_ior = (1 + root) / (1 - root);
  const vec3 r1 = (base_ior - film.ior) / (base_ior + film.ior);
  const vec3 r23 = mix(r1 * r1, vec3(1), schlick_weight(inside));
  // The reflection at a denser medium shifts the phase by pi.
  const vec3 shift = pi + pi * vec3(lessThan(base_ior, vec3(film.ior)));
  const float path_nm = 2 * film.ior * film.thickness_nm * inside;
  const vec3 round_trip = clamp(r12 * r23, 1e-5, 0.9999), amplitude = sqrt(round_trip);
  const vec3 base = t121 * t121 * r23 / (1 - round_trip);
  vec3 result = r12 + base, order = base - t121;
  for (int m = 1; m <= 2; ++m) {
    order *= amplitude;
    result += order * 2 * film_sensitivity(m * path_nm, m * shift);
  }
  return clamp(result, 0, 1);  // colours outside of the gamut
}

// Reflectance of the film on the whole surface.
vec3 film_reflectance(Film film, float cosine) {
  vec3 result = vec3(0);
  if (film.dielectric > 0) result += film.dielectric * thin_film(film, film.dielectric_f0, cosine);
  if (film.metal > 0) result += film.metal * thin_film(film, film.metal_f0, cosine);
  return result;
}

#endif
