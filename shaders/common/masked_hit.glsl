// The alpha test of a shadow ray's candidate hit.
#ifndef FIRE3DV_MASKED_HIT_GLSL
#define FIRE3DV_MASKED_HIT_GLSL
#include "common/textures.glsl"

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

#endif
