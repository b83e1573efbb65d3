// Ray-effect ray without a hit.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "ray_effects/effect_ray.glsl"

layout(location = 0) rayPayloadInEXT EffectRay ray;

void main() { ray.found = 0; }
