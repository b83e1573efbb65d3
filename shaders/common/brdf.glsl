// The metallic-roughness BRDF of glTF 2.0 (appendix B): Lambert and a Cook-Torrance lobe with GGX distribution (Walter
// et al. 2007), Schlick-GGX shadowing with the k for direct light (Karis 2013) and Schlick's Fresnel term (1994).
#ifndef FIRE3DV_BRDF_GLSL
#define FIRE3DV_BRDF_GLSL

const float PI = 3.14159265358979;

struct Surface {
  vec3 position_world;
  vec3 normal;       // shading normal, unit, towards the viewer's side
  vec3 to_eye;       // unit
  vec3 diffuse_color;
  vec3 f0;           // reflectance at normal incidence
  float roughness;   // perceptual
};

float distribution_ggx(float n_dot_h, float alpha) {
  const float a2 = alpha * alpha;
  const float d = n_dot_h * n_dot_h * (a2 - 1) + 1;
  return a2 / (PI * d * d);
}

float shadowing_schlick_ggx(float n_dot_v, float n_dot_l, float roughness) {
  const float k = (roughness + 1) * (roughness + 1) / 8;
  return 1 / ((n_dot_v * (1 - k) + k) * (n_dot_l * (1 - k) + k));  // over 4 * n_dot_v * n_dot_l, which cancel
}

vec3 fresnel_schlick(vec3 f0, float cos_theta) { return f0 + (1 - f0) * pow(1 - cos_theta, 5); }

// Reflected radiance per unit of irradiance measured across the light's direction, times cos(theta).
vec3 reflect_light(Surface s, vec3 to_light) {
  const float n_dot_l = dot(s.normal, to_light);
  if (n_dot_l <= 0) return vec3(0);
  const vec3 h = normalize(to_light + s.to_eye);
  const float n_dot_v = max(dot(s.normal, s.to_eye), 1e-4);
  const float n_dot_h = clamp(dot(s.normal, h), 0, 1);
  const float v_dot_h = clamp(dot(s.to_eye, h), 0, 1);
  const float alpha = max(s.roughness * s.roughness, 1e-3);
  const vec3 fresnel = fresnel_schlick(s.f0, v_dot_h);
  const vec3 specular = fresnel * (distribution_ggx(n_dot_h, alpha) * shadowing_schlick_ggx(n_dot_v, n_dot_l, s.roughness) / 4);
  const vec3 diffuse = (1 - fresnel) * s.diffuse_color / PI;
  return (diffuse + specular) * n_dot_l;
}

#endif
