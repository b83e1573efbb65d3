// Lookup table of directional albedo, by the root of n_dot_v (x) and roughness (y). r: share of light that white GGX
// facets lose in one bounce. g: weight of f90, so that the albedo is f0 * (1 - r - g) + f90 * g. b: sheen lobe. a: share
// that white facets lose below a smooth clearcoat by the minimum of passes_layer(). Split sum of Karis (2013) with height-correlated Smith shadowing and visible-normal
// sampling (Heitz 2018).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment_pass.glsl"
#include "material/brdf.glsl"

vec3 specular_albedo(float n_dot_v, float alpha) {
  const vec3 to_eye = vec3(sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  // View vector in the space where the microfacets form a hemisphere.
  const vec3 stretched = normalize(vec3(alpha * to_eye.x, 0, to_eye.z));
  const mat3 from_disk = mat3(vec3(0, 1, 0), cross(stretched, vec3(0, 1, 0)), stretched);
  const float kCoat = 0.96;  // of Schlick's term
  vec3 sum = vec3(0);
  for (uint i = 0; i < push.samples; ++i) {
    const vec2 u = hammersley(i, push.samples);
    // More samples of steep facets, which lose most.
    const float radius = sqrt(1 - (1 - u.x) * (1 - u.x) * (1 - u.x)), weight = 3 * (1 - u.x) * (1 - u.x), angle = 2 * PI * u.y;
    vec2 disk = radius * vec2(cos(angle), sin(angle));
    disk.y = mix(sqrt(1 - disk.x * disk.x), disk.y, 0.5 * (1 + stretched.z));
    const vec3 facet = from_disk * vec3(disk, sqrt(max(0, 1 - dot(disk, disk))));
    const vec3 half_vector = normalize(vec3(alpha * facet.xy, max(facet.z, 0)));
    const float v_dot_h = dot(to_eye, half_vector);
    const float n_dot_l = (2 * v_dot_h * half_vector - to_eye).z;
    if (n_dot_l <= 0 || v_dot_h <= 0) {
      sum.x += weight;
      continue;
    }
    // Ratio of G2 to G1; visible-normal sampling already includes G1.
    const float one_sided_visibility = 2 * n_dot_v / (n_dot_v + sqrt(n_dot_v * n_dot_v * (1 - alpha * alpha) + alpha * alpha));
    const float share = visibility_smith(n_dot_v, n_dot_l, alpha) * 4 * n_dot_v * n_dot_l / one_sided_visibility;
    const float grazing = pow(1 - v_dot_h, 5);
    const float hidden = kCoat * max(schlick_weight(n_dot_l) - schlick_weight(n_dot_v), 0);
    sum += weight * vec3(1 - share, share * grazing, share * hidden);
  }
  return sum / push.samples;
}

float sheen_albedo(float n_dot_v, float alpha) {
  const vec3 to_eye = vec3(sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  float sum = 0;
  for (uint i = 0; i < push.samples; ++i) {
    const vec2 u = hammersley(i, push.samples);
    const float n_dot_l = u.x * u.x;  // more samples at grazing angles
    const float across = sqrt(1 - n_dot_l * n_dot_l);
    const vec3 to_light = vec3(across * cos(2 * PI * u.y), across * sin(2 * PI * u.y), n_dot_l);
    const float n_dot_h = normalize(to_eye + to_light).z;
    sum += distribution_charlie(n_dot_h, alpha) * visibility_sheen(n_dot_v, n_dot_l, alpha) * n_dot_l * 2 * u.x;
  }
  return 2 * PI * sum / push.samples;
}

void main() {
  const ivec3 texel = ivec3(gl_GlobalInvocationID);
  if (texel.x >= push.size || texel.y >= push.size) return;
  // The outermost texels are at 0 and 1 (albedo_texel() in environment.glsl).
  const vec2 at = vec2(texel.xy) / (push.size - 1);
  const float n_dot_v = max(at.x * at.x, 1e-4), alpha = at.y * at.y;
  const vec3 specular = specular_albedo(n_dot_v, max(alpha, LEAST_ALPHA));
  const float sheen = min(sheen_albedo(n_dot_v, max(alpha, LEAST_SHEEN_ALPHA)), 1);
  imageStore(level_out, texel, vec4(specular.xy, sheen, specular.z));
}
