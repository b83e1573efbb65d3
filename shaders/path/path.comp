// Path tracing by ray query. Variant: FIRE3DV_CORE_MATERIALS.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#include "path/path.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { PathPush push; };

bool accepts_candidate(GlobalsRef globals, rayQueryEXT query, bool is_camera_ray, uvec4 random) {
  return accepts_hit(globals, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                     rayQueryGetIntersectionGeometryIndexEXT(query, false), rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                     rayQueryGetIntersectionBarycentricsEXT(query, false),
                     rayQueryGetIntersectionObjectRayDirectionEXT(query, false), is_camera_ray, random);
}

// Camera rays test the side of every surface, and so ask for all candidates.
Hit closest_hit(GlobalsRef globals, vec3 origin, float near_m, vec3 direction, float far_m, bool is_camera_ray, uvec4 random) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(globals.value.top_level),
                        is_camera_ray ? gl_RayFlagsNoOpaqueEXT : gl_RayFlagsNoneEXT, 0xff, origin, near_m,
                        direction, far_m);
  while (rayQueryProceedEXT(query)) {
    if (accepts_candidate(globals, query, is_camera_ray, random)) rayQueryConfirmIntersectionEXT(query);
  }
  Hit hit;
  hit.found = rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
  if (!hit.found) return hit;
  hit.node = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
  hit.geometry = rayQueryGetIntersectionGeometryIndexEXT(query, true);
  hit.triangle = rayQueryGetIntersectionPrimitiveIndexEXT(query, true);
  hit.barycentrics = rayQueryGetIntersectionBarycentricsEXT(query, true);
  hit.world_from_object = rayQueryGetIntersectionObjectToWorldEXT(query, true);
  return hit;
}

bool is_blocked(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m, uvec4 random) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(globals.value.top_level), gl_RayFlagsTerminateOnFirstHitEXT,
                        0xff, origin, 0, direction, distance_m);
  while (rayQueryProceedEXT(query)) {
    if (accepts_candidate(globals, query, false, random)) rayQueryConfirmIntersectionEXT(query);
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

void main() {
  if (gl_GlobalInvocationID.x < push.pixel_count) trace_pixel(push, gl_GlobalInvocationID.x);
}
