// Closest hit of a path ray. The ray-generation shader shades it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "path/path_ray.glsl"

layout(location = 0) rayPayloadInEXT PathRay ray;
hitAttributeEXT vec2 barycentrics;

void main() {
  ray.found = 1;
  ray.node = gl_InstanceCustomIndexEXT;
  ray.geometry = gl_GeometryIndexEXT;
  ray.triangle = gl_PrimitiveID;
  ray.barycentrics = barycentrics;
  ray.world_from_object = gl_ObjectToWorldEXT;
}
