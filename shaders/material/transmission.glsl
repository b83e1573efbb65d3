// Rough boundary between two transparent media: reflection and refraction by GGX facets (Walter et al. 2007) with all
// bounces among them, as a random walk (Heitz et al. 2016). The walk conserves energy whatever the roughness. Visible
// normals: Heitz 2018, drawn as spherical caps (Dupuy and Benyoub 2023). Used by the path tracer alone.
#ifndef FIRE3DV_TRANSMISSION_GLSL
#define FIRE3DV_TRANSMISSION_GLSL
#include "common/directions.glsl"
#include "material/brdf.glsl"
#include "path/random.glsl"

struct Boundary {
  vec3 normal;  // of the facets' mean plane, unit, on the eye's side
  float alpha;
  float ior;    // of the medium behind, relative to that on the eye's side
  vec3 f0;      // reflectance of a facet at normal incidence; white: its largest channel enters
  float f90;
  vec3 color;   // of light that passes
  Film film;    // on the side of the thinner medium, taken for air
};

// Below it a boundary is a mirror to lamps and to the environment's samples: their light passes by sampled directions.
const float kSmoothAlpha = 2e-3;
// Ratios that do not bend light.
const float kNoRefraction = 1e-4;
const int kFacetBounces = 16;

bool is_smooth(Boundary b) { return b.alpha <= kSmoothAlpha; }

// Fresnel's equations, unpolarised. 1: total reflection.
float dielectric_reflectance(float cosine, float ior) {
  const float sine2 = (1 - cosine * cosine) / (ior * ior);
  if (sine2 >= 1) return 1;
  const float behind = sqrt(1 - sine2);
  const float s = (cosine - ior * behind) / (cosine + ior * behind), p = (ior * cosine - behind) / (ior * cosine + behind);
  return 0.5 * (s * s + p * p);
}

// Share of light that passes: the complement of the largest channel, of a film that of each.
vec3 boundary_passed(Boundary b, vec3 reflected) {
  const vec3 plain = vec3(1 - largest(reflected));
  return kIridescence && b.film.weight > 0 ? mix(plain, 1 - reflected, b.film.weight) : plain;
}

// Scales Fresnel's equations to the reflectances of KHR_materials_specular. Total reflection stays total. A film reflects
// to both sides alike, since it does not absorb.
vec3 boundary_reflectance(Boundary b, float ior, float cosine) {
  const float exact = dielectric_reflectance(cosine, ior);
  if (exact >= 1) return vec3(1);
  const float normal_incidence = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1));
  const vec3 reflected = mix(b.f0, vec3(b.f90), max(exact - normal_incidence, 0) / (1 - normal_incidence));
  if (!kIridescence || b.film.weight <= 0) return reflected;
  const float outside = ior >= 1 ? cosine : sqrt(max(1 - (1 - cosine * cosine) / (ior * ior), 0));
  return mix(reflected, thin_film(b.film, b.f0, outside), b.film.weight);
}

// Smith's lambda for directions above (z > 0) and below the facets.
float smith_lambda(float z, float alpha) {
  const float z2 = max(z * z, 1e-14);
  const float root = sqrt(1 + alpha * alpha * max(1 - z2, 0) / z2);
  return 0.5 * (z > 0 ? root - 1 : -1 - root);
}

// Area of the visible facets per unit of the mean plane, seen from a direction on either side.
float visible_area(float z, float alpha) { return 0.5 * (z + sqrt(z * z + alpha * alpha * max(1 - z * z, 0))); }

vec3 sample_visible_normal(vec3 eye, float alpha, vec2 u) {
  const vec3 stretched = normalize(vec3(alpha * eye.xy, eye.z));
  const float angle = 2 * PI * u.x;
  const float z = (1 - u.y) * (1 + stretched.z) - stretched.z;
  const float sine = sqrt(clamp(1 - z * z, 0, 1));
  const vec3 cap = vec3(sine * cos(angle), sine * sin(angle), z) + stretched;
  return normalize(vec3(alpha * cap.xy, max(cap.z, 1e-9)));
}

// Density of directions after one facet, per unit of solid angle: light comes from `to_light`, on either side.
vec3 facet_density(Boundary b, float ior, vec3 eye, vec3 to_light) {
  const bool passes = to_light.z < 0;
  vec3 h = passes ? eye + ior * to_light : eye + to_light;
  if (dot(h, h) < 1e-12) return vec3(0);
  h = normalize(h);
  if (h.z < 0) h = -h;
  const float eye_h = dot(eye, h), light_h = dot(to_light, h);
  if (eye_h <= 0 || (passes ? light_h >= 0 : light_h <= 0)) return vec3(0);
  const float density = distribution_ggx(min(h.z, 1), b.alpha) / visible_area(eye.z, b.alpha);
  const vec3 reflected = boundary_reflectance(b, ior, eye_h);
  if (!passes) return reflected * density / 4;
  const float bent = eye_h + ior * light_h;
  return boundary_passed(b, reflected) * (density * eye_h * -light_h * ior * ior / max(bent * bent, 1e-12));
}

vec3 flipped(vec3 v) { return vec3(v.xy, -v.z); }

struct BoundaryWalk {
  vec3 direction;   // sampled: where light comes from
  vec3 weight;      // of its radiance
  vec3 scattered;   // radiance towards the eye per unit of irradiance perpendicular to `to_light`, an estimate
};

// seed: random. to_light: zero, or a direction whose light is to be evaluated.
BoundaryWalk walk_boundary(Boundary b, vec3 to_eye, uvec4 seed, vec3 to_light) {
  const mat3 world_from_local = frame_around(b.normal);
  const bool evaluates = dot(to_light, to_light) > 0;
  vec3 eye = to_eye * world_from_local;
  if (eye.z < 1e-4) eye = normalize(vec3(eye.xy, 1e-4));
  // Of the side that the ray is on: z points away from the facets. height: share of the facets below the ray.
  vec3 direction = -eye, light = to_light * world_from_local, weight = vec3(1), scattered = vec3(0);
  float ior = b.ior, height = 1;
  bool is_behind = false;
  const vec3 passed = b.color / (b.ior * b.ior);  // radiance is proportional to the square of the index
  for (int bounce = 0; bounce < kFacetBounces; ++bounce) {
    const vec4 u = unit_numbers(pcg4d(seed + uvec4(0, 0, 0, bounce)));
    const float lambda = smith_lambda(direction.z, b.alpha), chance = 1 - u.x;
    if (direction.z > 0 && (lambda < 1e-7 || chance < pow(height, lambda))) break;
    height = clamp(height * pow(chance, -1 / lambda), 1e-7, 1);
    const vec3 back = -direction;
    if (evaluates && light.z != 0) {
      const float shadowing = light.z > 0 ? pow(height, smith_lambda(light.z, b.alpha))
                                          : pow(max(1 - height, 1e-7), smith_lambda(-light.z, b.alpha));
      scattered += weight * shadowing * facet_density(b, ior, back, light);
    }
    const vec3 facet = sample_visible_normal(back, b.alpha, u.yz);
    const float cosine = clamp(dot(back, facet), 0, 1);
    const vec3 reflected = boundary_reflectance(b, ior, cosine);
    const float reflects = largest(reflected);
    if (u.w < reflects) {
      weight *= reflected / reflects;
      direction = normalize(direction + 2 * cosine * facet);
      continue;
    }
    weight *= boundary_passed(b, reflected) / (1 - reflects);
    const float behind = sqrt(max(1 - (1 - cosine * cosine) / (ior * ior), 0));
    direction = flipped(normalize(direction / ior + (cosine / ior - behind) * facet));
    light = flipped(light);
    height = max(1 - height, 1e-7);
    ior = 1 / ior;
    is_behind = !is_behind;
  }
  BoundaryWalk walk;
  direction.z = max(abs(direction.z), 1e-6);
  walk.direction = normalize(world_from_local * (is_behind ? flipped(direction) : direction));
  walk.weight = weight * (is_behind ? passed : vec3(1));
  walk.scattered = scattered * (dot(to_light, b.normal) < 0 ? passed : vec3(1));
  return walk;
}

// Approximate density of sampled directions, positive wherever light is scattered: for weights that sum to 1.
float boundary_pdf(Boundary b, vec3 to_eye, vec3 to_light) {
  const mat3 world_from_local = frame_around(b.normal);
  vec3 eye = to_eye * world_from_local;
  if (eye.z < 1e-4) eye = normalize(vec3(eye.xy, 1e-4));
  const vec3 light = to_light * world_from_local;
  return 0.9 * largest(facet_density(b, b.ior, eye, light)) + 0.1 * abs(light.z) / (2 * PI);
}

// Rest of a surface of which the share `share` is transparent: without the dielectric reflection of that share.
// f0, f90: of the dielectric.
Surface without_boundary(Surface s, float share, vec3 f0, float f90) {
  const vec2 split = lobe_split(s.base, s.to_eye, s.base.n_dot_v);
  s.transmitted = vec3(0);
  s.base.f0 = max(s.base.f0 - share * f0, 0);
  s.base.f90 = max(s.base.f90 - share * f90, 0);
  s.base.albedo = s.base.f0 * split.x + s.base.f90 * split.y;
  vec3 multiple = multiple_scattering(f0, vec3(f90), mean_loss(s.base.roughness));
  if (has_film(s)) {
    s.film.dielectric = max(s.film.dielectric - share, 0);
    s.base.albedo = mix(s.base.albedo, film_albedo(s.film, s.base.n_dot_v, s.base.roughness, split), s.film.weight);
    multiple = mix(multiple, s.film.dielectric_multiple, s.film.weight);
  }
  s.base.multiple = max(s.base.multiple - share * s.base.loss * multiple, 0);
  return s;
}

#endif
