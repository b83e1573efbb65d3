// Hard shadows by ray query. Opaque surfaces stop a ray; masked ones stop it where they are opaque; blended ones cast
// no shadow.
#ifndef FIRE3DV_SHADOW_RAYS_GLSL
#define FIRE3DV_SHADOW_RAYS_GLSL
#extension GL_EXT_ray_query : require
#include "common/textures.glsl"

layout(set = 0, binding = FIRE3DV_BINDING_TOP_LEVEL) uniform accelerationStructureEXT top_level;

bool masked_hit_is_solid(GlobalsRef globals, uint node, uint geometry, uint triangle, vec2 barycentrics) {
  const uint primitive_index = UintRef(globals.value.first_primitive_of_node).at[node] + geometry;
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[primitive_index];
  const uint first = primitive.first_index + 3 * triangle;
  UintRef indices = UintRef(globals.value.indices);
  const vec3 weight = vec3(1 - barycentrics.x - barycentrics.y, barycentrics);
  vec4 uv = vec4(0);
  float alpha = 0;
  for (uint corner = 0; corner < 3; ++corner) {
    const uint vertex_index = primitive.first_vertex + indices.at[first + corner];
    const VertexRecord vertex = VertexRef(globals.value.vertices).at[vertex_index];
    uv += weight[corner] * vec4(vertex.uv0, vertex.uv1);
    alpha += weight[corner] * vertex.color.a;
  }
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  alpha *= material.base_color.a * sample_level0_or(material.base_color_texture, uv, vec4(1)).a;
  return alpha >= material.alpha_cutoff;
}

bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, top_level, gl_RayFlagsTerminateOnFirstHitEXT, 0xff, origin, 0, direction, distance_m);
  while (rayQueryProceedEXT(query)) {
    if (rayQueryGetIntersectionTypeEXT(query, false) != gl_RayQueryCandidateIntersectionTriangleEXT) continue;
    if (masked_hit_is_solid(globals, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false),
                            rayQueryGetIntersectionGeometryIndexEXT(query, false),
                            rayQueryGetIntersectionPrimitiveIndexEXT(query, false),
                            rayQueryGetIntersectionBarycentricsEXT(query, false))) {
      rayQueryConfirmIntersectionEXT(query);
    }
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

// A point off the surface, far enough that rounding cannot put the origin below it: the error of an interpolated
// position is a few units in the last place of its largest coordinate or of its distance to the eye, and near an edge a
// fraction of a pixel. So the offset scales with the scene and the view: a needle seen from 0.1 m gets about 1e-5 m.
vec3 offset_from_surface(vec3 position_world, vec3 geometric_normal, vec3 eye_world, float pixel_size_m) {
  const vec3 size = max(abs(position_world), abs(position_world - eye_world));
  const float rounding = max(size.x, max(size.y, size.z)) / 262144.0;  // 2^-18
  return position_world + geometric_normal * (rounding + 0.1 * pixel_size_m);
}

#endif
