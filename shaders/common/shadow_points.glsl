// The points of a pixel that shadow rays start from: one for each triangle that its samples show, in the middle of the
// samples, where shading looks at the triangle, too.
#ifndef FIRE3DV_SHADOW_POINTS_GLSL
#define FIRE3DV_SHADOW_POINTS_GLSL
#include "common/lights.glsl"
#include "common/pixel_ids.glsl"
#include "common/shadow_ray.glsl"
#include "common/visible_triangle.glsl"

SurfacePoint shadow_point(GlobalsRef globals, uint id, uint same, uint pixel) {
  const uvec2 corner = uvec2(pixel % globals.value.width, pixel / globals.value.width);
  return surface_point(globals, visible_triangle(globals, id), place_of_samples(corner, same));
}

// Whether light from there can make a difference: to a surface without a normal map only from before it.
bool light_matters(GlobalsRef globals, SurfacePoint point, LightSample light) {
  if (max(light.irradiance.r, max(light.irradiance.g, light.irradiance.b)) <= 0) return false;
  const MaterialRecord material = MaterialRef(globals.value.materials).at[point.material];
  if (material.normal_texture.texture != FIRE3DV_NO_INDEX) return true;
  if ((material.flags & FIRE3DV_MATERIAL_CLEARCOAT) != 0) return true;  // may have a normal map of its own
  return dot(point.normal_world, light.to_light) > 0;
}

#endif
