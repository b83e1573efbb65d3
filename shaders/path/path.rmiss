// Path ray without a hit.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "path/path_ray.glsl"

layout(location = 0) rayPayloadInEXT PathRay ray;

void main() { ray.found = 0; }
