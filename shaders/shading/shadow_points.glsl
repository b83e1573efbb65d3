// Origins of a pixel's shadow rays: one per visible triangle, at the mean position of its samples, as in
// shading.
#ifndef FIRE3DV_SHADOW_POINTS_GLSL
#define FIRE3DV_SHADOW_POINTS_GLSL
#include "shading/lights.glsl"
#include "common/pixel_ids.glsl"
#include "shading/shadow_ray.glsl"
#include "common/visible_triangle.glsl"

SurfacePoint shadow_point(GlobalsRef globals, uint id, uint same, uint pixel) {
  const uvec2 corner = uvec2(pixel % globals.value.width, pixel / globals.value.width);
  return surface_point(globals, visible_triangle(globals, id), position_of_samples(corner, same));
}

// True if light from this direction can affect the surface: light above it, and without a normal map only light from
// the front. Transmissive surfaces have light from both sides.
bool light_matters(GlobalsRef globals, SurfacePoint point, LightSample light) {
  if (max(light.irradiance.r, max(light.irradiance.g, light.irradiance.b)) <= 0) return false;
  const MaterialRecord material = MaterialRef(globals.value.materials).at[point.material];
  if ((material.flags & FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION) != 0) return true;
  if ((material.flags & FIRE3DV_MATERIAL_TRANSMISSION) == 0 && !is_above_surface(point, light.to_light)) return false;
  if (material.normal_texture.texture != FIRE3DV_NO_INDEX) return true;
  if ((material.flags & FIRE3DV_MATERIAL_CLEARCOAT) != 0) return true;  // may have its own normal map
  return dot(point.normal_world, light.to_light) > 0;
}

#endif
