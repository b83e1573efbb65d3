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
  float smooth_height_m;    // see smooth_height(); 0: flat, concave or transmissive
  uint material;
};

// Height above the triangle of the convex surface that its vertex normals describe: mean of the vertices' tangent
// planes (Hanika 2021). normal: of the front. barycentrics: of the point. 0: a flat or concave triangle.
float smooth_height(vec3 corner[3], vec3 normal[3], vec3 barycentrics, bool is_back_face) {
  const float side = is_back_face ? -1 : 1;
  const vec3 curvature = side * vec3(dot(corner[0] - corner[1], normal[0] - normal[1]), dot(corner[1] - corner[2], normal[1] - normal[2]),
                              dot(corner[2] - corner[0], normal[2] - normal[0]));
  const float height = max(dot(barycentrics * barycentrics.yzx, curvature), 1e-30);
  return curvature.x + curvature.y + curvature.z > 0 ? height : 0;
}

// True for directions to which opaque lobes reflect: above the triangle. A convex smooth-shaded triangle takes the
// interpolated normal instead, as the surface that it stands for does: docs/design/shadows.md.
bool is_above_surface(SurfacePoint point, vec3 direction) {
  return dot(point.smooth_height_m > 0 ? point.normal_world : point.plane_normal_world, direction) > 0;
}

// True for rays that start on the triangle's far side. Callers exclude directions without light.
bool starts_behind(SurfacePoint point, vec3 direction) {
  return point.smooth_height_m == 0 && dot(point.plane_normal_world, direction) < 0;
}

// Additional height of a ray's origin: a ray below the triangle's plane starts on the smooth surface.
float start_height(SurfacePoint point, vec3 direction) {
  return dot(point.plane_normal_world, direction) < 0 ? point.smooth_height_m : 0;
}

#endif
