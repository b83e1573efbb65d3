// Two rays of `fire3dv doctor` from the origin, by ray query: a triangle is one metre away along +Z. probe_ray.rgen: the same
// by a ray-tracing pipeline.
#version 460
#extension GL_EXT_ray_query : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer HitsRef { uint at[2]; };
layout(push_constant, scalar) uniform Push {
  uint64_t top_level;
  uint64_t hits;  // of the ray along +Z, and of one along -Z
};

bool meets(vec3 direction) {
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(top_level), gl_RayFlagsOpaqueEXT, 0xff, vec3(0), 0, direction, 10);
  while (rayQueryProceedEXT(query)) {
  }
  return rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT;
}

void main() {
  HitsRef(hits).at[0] = meets(vec3(0, 0, 1)) ? 1 : 0;
  HitsRef(hits).at[1] = meets(vec3(0, 0, -1)) ? 1 : 0;
}
