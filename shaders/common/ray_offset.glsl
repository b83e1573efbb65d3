#ifndef FIRE3DV_RAY_OFFSET_GLSL
#define FIRE3DV_RAY_OFFSET_GLSL

// A point off the surface, far enough that rounding cannot put the origin below it: the error of an interpolated
// position is a few units in the last place of its largest coordinate or of its distance to the eye, and near an edge a
// fraction of a pixel. So the offset scales with the scene and the view: a needle seen from 0.1 m gets about 1e-5 m.
vec3 offset_from_surface(vec3 position_world, vec3 geometric_normal, vec3 eye_world, float pixel_size_m) {
  const vec3 size = max(abs(position_world), abs(position_world - eye_world));
  const float rounding = max(size.x, max(size.y, size.z)) / 262144.0;  // 2^-18
  return position_world + geometric_normal * (rounding + 0.1 * pixel_size_m);
}

#endif
