// Intersection of a shadow ray with the triangles of a box, for devices that trace rays to boxes
// (gpu::traces_to_boxes).
#ifndef FIRE3DV_RAY_BOXES_GLSL
#define FIRE3DV_RAY_BOXES_GLSL
#include "common/buffers.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayBoxRef { RayBoxRecord at[]; };

// Side of an edge relative to the ray (twice the projected area). For the adjacent triangle it has the same
// bits and the opposite sign, so no ray passes between the two.
float side_of(vec3 direction, vec3 a, vec3 b) {
  precise const vec3 normal = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  precise const float side = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z;
  return side;
}

// Ray-triangle test in Plücker coordinates (Shoemake 1998). Vertices are relative to the ray's origin.
bool meets_triangle(vec3 direction, float distance, vec3 a, vec3 b, vec3 c) {
  const float u = side_of(direction, c, b), v = side_of(direction, a, c), w = side_of(direction, b, a);
  const bool inside = min(u, min(v, w)) >= 0 || max(u, max(v, w)) <= 0;
  const vec3 normal = cross(b - a, c - a);
  const float speed = dot(normal, direction), away = dot(normal, a);  // towards the plane; distance to the
                                                                      // plane
  // 0 <= away / speed <= distance
  return inside && speed != 0 && (speed > 0 ? away >= 0 && away <= distance * speed : away <= 0 && away >= distance * speed);
}

// The bounds checks guard against llvmpipe: for meshes near the float range it combined one mesh's instance
// with another's box index.
bool meets_box(GlobalsRef globals, uint node, uint geometry, uint number, vec3 origin, vec3 direction, float distance) {
  const uint primitive = UintRef(globals.value.first_primitive_of_node).at[node] + geometry;
  if (primitive >= globals.value.primitive_count) return false;
  const uint box = PrimitiveRef(globals.value.primitives).at[primitive].first_ray_box + number;
  if (box >= globals.value.ray_box_count) return false;
  RayBoxRef boxes = RayBoxRef(globals.value.ray_boxes);
  const uint first_vertex = boxes.at[box].first_vertex, triangles = boxes.at[box].triangles;
  const uint first = triangles & ((1u << FIRE3DV_RAY_BOX_COUNT_SHIFT) - 1), last = first + (triangles >> FIRE3DV_RAY_BOX_COUNT_SHIFT);
  PositionRef positions = PositionRef(globals.value.positions);
  for (uint triangle = first; triangle <= last; ++triangle) {
    const uint packed = UintRef(globals.value.cluster_triangles).at[triangle];
    const vec3 a = positions.at[first_vertex + (packed & 255)] - origin;
    const vec3 b = positions.at[first_vertex + ((packed >> 8) & 255)] - origin;
    const vec3 c = positions.at[first_vertex + ((packed >> 16) & 255)] - origin;
    if (meets_triangle(direction, distance, a, b, c)) return true;
  }
  return false;
}

#endif
