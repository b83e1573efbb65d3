// Ray effects by ray query. Variants: FIRE3DV_SAMPLES 1 or 4, FIRE3DV_CORE_MATERIALS.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#include "ray_effects/effect_hit.glsl"
#include "ray_effects/ray_effects.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

bool accepts_candidate(GlobalsRef globals, rayQueryEXT query, bool meets_all) {
  return accepts_effect_hit(globals, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                            rayQueryGetIntersectionGeometryIndexEXT(query, false),
                            rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                            rayQueryGetIntersectionBarycentricsEXT(query, false), meets_all);
}

bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(globals.value.top_level), gl_RayFlagsTerminateOnFirstHitEXT,
                        0xff, origin, 0, direction, distance_m);
  while (rayQueryProceedEXT(query)) {
    if (accepts_candidate(globals, query, false)) rayQueryConfirmIntersectionEXT(query);
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

Hit closest_hit(vec3 origin, vec3 direction, float distance_m, bool meets_all) {
  GlobalsRef globals = GlobalsRef(push.globals);
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(globals.value.top_level), gl_RayFlagsNoneEXT, 0xff, origin, 0,
                        direction, distance_m);
  while (rayQueryProceedEXT(query)) {
    if (accepts_candidate(globals, query, meets_all)) rayQueryConfirmIntersectionEXT(query);
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

void main() { trace_effects(gl_GlobalInvocationID.xy); }
