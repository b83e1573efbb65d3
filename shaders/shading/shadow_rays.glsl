// Hard shadows by ray query. Opaque surfaces block a ray, masked ones block it where their alpha test passes,
// blended ones cast no shadow. With FIRE3DV_RAY_BOXES some meshes are traced as boxes, see ray_aabbs.glsl.
#ifndef FIRE3DV_SHADOW_RAYS_GLSL
#define FIRE3DV_SHADOW_RAYS_GLSL
#extension GL_EXT_ray_query : require
#include "shading/masked_hit.glsl"
#ifdef FIRE3DV_RAY_BOXES
#include "shading/ray_aabbs.glsl"
#endif


bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(globals.value.top_level), gl_RayFlagsTerminateOnFirstHitEXT,
                        0xff, origin, 0, direction, distance_m);
  while (rayQueryProceedEXT(query)) {
    if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT) {
#ifdef FIRE3DV_RAY_BOXES
      if (meets_box(globals, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                    rayQueryGetIntersectionGeometryIndexEXT(query, false), rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                    rayQueryGetIntersectionObjectRayOriginEXT(query, false),
                    rayQueryGetIntersectionObjectRayDirectionEXT(query, false), distance_m)) {
        return true;
      }
#endif
      continue;
    }
    if (masked_hit_is_solid(globals, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                            rayQueryGetIntersectionGeometryIndexEXT(query, false),
                            rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                            rayQueryGetIntersectionBarycentricsEXT(query, false))) {
      rayQueryConfirmIntersectionEXT(query);
    }
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

#endif
