// Lookup table of directional albedo, by n_dot_v (x) and roughness (y). r, g: GGX lobe, albedo = f0 * r + f90
// * g. b: sheen lobe. Split sum of Karis (2013) with height-correlated Smith shadowing and visible-normal
// sampling (Heitz 2018).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment_pass.glsl"
#include "material/brdf.glsl"

vec2 specular_albedo(float n_dot_v, float alpha) {
  const vec3 to_eye = vec3(sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  // View vector in the space where the microfacets form a hemisphere.
  const vec3 stretched = normalize(vec3(alpha * to_eye.x, 0, to_eye.z));
  const mat3 from_disk = mat3(vec3(0, 1, 0), cross(stretched, vec3(0, 1, 0)), stretched);
  vec2 sum = vec2(0);
  for (uint i = 0; i < push.samples; ++i) {
    const vec2 u = hammersley(i, push.samples);
    const float radius = sqrt(u.x), angle = 2 * PI * u.y;
    vec2 disk = radius * vec2(cos(angle), sin(angle));
    disk.y = mix(sqrt(1 - disk.x * disk.x), disk.y, 0.5 * (1 + stretched.z));
    const vec3 facet = from_disk * vec3(disk, sqrt(max(0, 1 - dot(disk, disk))));
    const vec3 half_vector = normalize(vec3(alpha * facet.xy, max(facet.z, 0)));
    const float v_dot_h = dot(to_eye, half_vector);
    const float n_dot_l = (2 * v_dot_h * half_vector - to_eye).z;
    if (n_dot_l <= 0 || v_dot_h <= 0) continue;
    // Ratio of G2 to G1; visible-normal sampling already includes G1.
    const float one_sided_visibility = 2 * n_dot_v / (n_dot_v + sqrt(n_dot_v * n_dot_v * (1 - alpha * alpha) + alpha * alpha));
    const float share = visibility_smith(n_dot_v, n_dot_l, alpha) * 4 * n_dot_v * n_dot_l / one_sided_visibility;
    const float grazing = pow(1 - v_dot_h, 5);
    sum += share * vec2(1 - grazing, grazing);
  }
  return sum / push.samples;
}

float sheen_albedo(float n_dot_v, float alpha) {
  const vec3 to_eye = vec3(sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  float sum = 0;
  for (uint i = 0; i < push.samples; ++i) {
    const vec2 u = hammersley(i, push.samples);
    const float n_dot_l = u.x;
    const float across = sqrt(1 - u.x * u.x);
    const vec3 to_light = vec3(across * cos(2 * PI * u.y), across * sin(2 * PI * u.y), n_dot_l);
    const float n_dot_h = normalize(to_eye + to_light).z;
    sum += distribution_charlie(n_dot_h, alpha) * visibility_sheen(n_dot_v, n_dot_l, alpha) * n_dot_l;
  }
  return 2 * PI * sum / push.samples;
}

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  // The outermost texels are at 0 and 1 (albedo_texel() in environment.glsl).
  const vec2 at = max(vec2(texel.xy) / (push.size - 1), vec2(1e-3, 0));
  const float alpha = at.y * at.y;
  imageStore(level_out, texel,
             vec4(specular_albedo(at.x, max(alpha, LEAST_ALPHA)), min(sheen_albedo(at.x, max(alpha, LEAST_SHEEN_ALPHA)), 1), 1));
}
