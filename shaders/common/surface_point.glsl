#ifndef FIRE3DV_SURFACE_POINT_GLSL
#define FIRE3DV_SURFACE_POINT_GLSL

// What a raster path knows of a point that the eye sees.
struct SurfacePoint {
  vec3 position_world;
  vec3 plane_normal_world;  // of the triangle, unit, on the eye's side
  vec3 normal_world;        // interpolated, unit, on the seen side
  vec4 tangent_world;       // w: sign of the bitangent
  vec4 uv;                  // both sets
  vec4 uv_dx, uv_dy;        // their change from this pixel to the next to the right and below
  vec4 color;
  float pixel_size_m;       // the smaller side of the pixel on the triangle's plane
  float lift_m;             // of a coarser level: how far the file's own surface may lie above the point
  uint material;
};

#endif
