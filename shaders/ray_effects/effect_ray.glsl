// Payload of a ray-effect ray, and its acceptance of candidate hits.
#ifndef FIRE3DV_EFFECT_RAY_GLSL
#define FIRE3DV_EFFECT_RAY_GLSL

// In: meets_all. Out: the closest hit. Rays that only test for a blocker have no closest hit; their miss shader clears
// `found`.
struct EffectRay {
  uint meets_all;  // 1: also blended and transmissive surfaces
  uint found;
  uint node, geometry, triangle;
  vec2 barycentrics;
  mat4x3 world_from_object;
};

#endif
