// Candidate hits that are not opaque, of ray-effect rays.
#ifndef FIRE3DV_EFFECT_HIT_GLSL
#define FIRE3DV_EFFECT_HIT_GLSL
#include "path/hit.glsl"

// meets_all: blended and transmissive surfaces are hit, too. Masked surfaces are hit where they are solid.
bool accepts_effect_hit(GlobalsRef globals, uint node, uint geometry, uint triangle, vec2 barycentrics, bool meets_all) {
  const PrimitiveRecord primitive = primitive_of_hit(globals, node, geometry);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  const uint see_through = FIRE3DV_MATERIAL_BLEND | FIRE3DV_MATERIAL_TRANSMISSION;
  if (!meets_all && (material.flags & see_through) != 0) return false;
  if ((material.flags & FIRE3DV_MATERIAL_MASK) == 0) return true;
  return alpha_of_hit(globals, primitive, material, triangle, barycentrics) >= material.alpha_cutoff;
}

#endif
