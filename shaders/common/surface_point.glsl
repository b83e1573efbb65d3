// Surface point: the shading input that every raster path produces.
#ifndef FIRE3DV_SURFACE_POINT_GLSL
#define FIRE3DV_SURFACE_POINT_GLSL

// Visible point of a surface.
struct SurfacePoint {
  vec3 position_world;
  vec3 plane_normal_world;  // of the triangle, unit, on the eye's side
  vec3 normal_world;        // interpolated, unit, on the visible side
  vec4 tangent_world;       // w: sign of the bitangent
  vec4 uv;                  // both sets
  vec4 uv_dx, uv_dy;        // derivatives to the next pixel right and below
  vec4 color;
  float pixel_size_m;       // smaller side of the pixel on the triangle's plane
  float lift_m;             // coarser LOD: maximum height of the LOD 0 surface above the point
  uint material;
};

#endif
