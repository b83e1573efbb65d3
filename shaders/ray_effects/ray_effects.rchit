// Closest hit of a ray-effect ray. The ray-generation shader shades it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "ray_effects/effect_ray.glsl"

layout(location = 0) rayPayloadInEXT EffectRay ray;
hitAttributeEXT vec2 barycentrics;

void main() {
  ray.found = 1;
  ray.node = gl_InstanceCustomIndexEXT;
  ray.geometry = gl_GeometryIndexEXT;
  ray.triangle = gl_PrimitiveID;
  ray.barycentrics = barycentrics;
  ray.world_from_object = gl_ObjectToWorldEXT;
}
