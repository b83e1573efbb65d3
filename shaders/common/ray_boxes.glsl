// Triangles of a box that a ray has come to, one by one: for devices that trace rays to boxes (gpu::traces_to_boxes).
#ifndef FIRE3DV_RAY_BOXES_GLSL
#define FIRE3DV_RAY_BOXES_GLSL
#include "common/buffers.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayBoxRef { RayBoxRecord at[]; };

// Twice the area that an edge spans with the ray, as seen along it. Of the triangle on the other side of the edge it is
// the same number to the bit, with the other sign: nothing comes through between the two.
float side_of(vec3 direction, vec3 a, vec3 b) {
  precise const vec3 normal = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  precise const float side = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z;
  return side;
}

// Corners from the ray's origin. As Plücker coordinates have it (Shoemake 1998).
bool meets_triangle(vec3 direction, float distance, vec3 a, vec3 b, vec3 c) {
  const float u = side_of(direction, c, b), v = side_of(direction, a, c), w = side_of(direction, b, a);
  const bool inside = min(u, min(v, w)) >= 0 || max(u, max(v, w)) <= 0;
  const vec3 normal = cross(b - a, c - a);
  const float speed = dot(normal, direction), away = dot(normal, a);  // towards the plane, and of it
  // 0 <= away / speed <= distance
  return inside && speed != 0 && (speed > 0 ? away >= 0 && away <= distance * speed : away <= 0 && away >= distance * speed);
}

// Where bodies are as large as numbers go, llvmpipe was seen to name a candidate by one body's instance and another's
// box: nothing is read beyond the ends.
bool meets_box(GlobalsRef globals, uint node, uint geometry, uint number, vec3 origin, vec3 direction, float distance) {
  const uint primitive = UintRef(globals.value.first_primitive_of_node).at[node] + geometry;
  if (primitive >= globals.value.primitive_count) return false;
  const uint place = PrimitiveRef(globals.value.primitives).at[primitive].first_ray_box + number;
  if (place >= globals.value.ray_box_count) return false;
  RayBoxRef boxes = RayBoxRef(globals.value.ray_boxes);
  const uint first_vertex = boxes.at[place].first_vertex, triangles = boxes.at[place].triangles;
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
