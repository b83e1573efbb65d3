// Alpha of a ray's candidate hit, and the alpha test of shadow rays.
#ifndef FIRE3DV_MASKED_HIT_GLSL
#define FIRE3DV_MASKED_HIT_GLSL
#include "common/textures.glsl"
#include "common/vertices.glsl"

float alpha_of_hit(GlobalsRef globals, PrimitiveRecord primitive, MaterialRecord material, uint triangle,
                   vec2 barycentrics) {
  const uint first = primitive.first_index + 3 * triangle;
  UintRef indices = UintRef(globals.value.indices);
  const vec3 weight = vec3(1 - barycentrics.x - barycentrics.y, barycentrics);
  ExtrasRef extras = ExtrasRef(globals.value.extras);
  vec4 uv = vec4(0);
  float alpha = 0;
  for (uint corner = 0; corner < 3; ++corner) {
    const uint vertex = primitive.first_vertex + indices.at[first + corner];
    uv += weight[corner] * vec4(UvRef(globals.value.uvs).at[vertex], uv1_of(extras, vertex));
    alpha += weight[corner] * color_of(extras, vertex).a;
  }
  return alpha * material.base_color.a * sample_level0_or(material.base_color_texture, uv, vec4(1)).a;
}

bool masked_hit_is_solid(GlobalsRef globals, uint node, uint geometry, uint triangle, vec2 barycentrics) {
  const uint primitive_index = UintRef(globals.value.first_primitive_of_node).at[node] + geometry;
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[primitive_index];
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  if ((material.flags & (FIRE3DV_MATERIAL_BLEND | FIRE3DV_MATERIAL_TRANSMISSION)) != 0) return false;  // no shadow
  return alpha_of_hit(globals, primitive, material, triangle, barycentrics) >= material.alpha_cutoff;
}

#endif
