// Payload of a path ray, and its counter.
#ifndef FIRE3DV_PATH_RAY_GLSL
#define FIRE3DV_PATH_RAY_GLSL

// In: random, is_camera_ray. Out: the closest hit. Rays that only test for a blocker have no closest hit; their miss
// shader clears `found`.
struct PathRay {
  uvec4 random;
  uint is_camera_ray;
  uint found;
  uint node, geometry, triangle;
  vec2 barycentrics;
  mat4x3 world_from_object;
};

#endif
