// Counter-based random numbers: a hash of pixel, sample, dimension and seed, without state. The same counters
// give the same numbers on every device and in every order of work. PCG in four dimensions (Jarzynski and Olano
// 2020).
#ifndef FIRE3DV_RANDOM_GLSL
#define FIRE3DV_RANDOM_GLSL

uvec4 pcg4d(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// From 0 to 1, without 1.
vec4 unit_numbers(uvec4 words) { return vec4(words >> 8u) * (1.0 / 16777216.0); }

#endif
