// Closed shapes of markers, vertex by vertex, counter-clockwise seen from outside.
#ifndef FIRE3DV_MARKER_SOLIDS_GLSL
#define FIRE3DV_MARKER_SOLIDS_GLSL

struct SolidVertex {
  vec3 point;
  vec3 normal;  // not of unit length
};

const float kTurn = 6.28318530718;

// Corners of two triangles on a rectangle: 0 or 1 along two axes whose cross product points outwards.
const uvec2 kRectangle[6] = uvec2[6](uvec2(0, 0), uvec2(1, 0), uvec2(1, 1), uvec2(0, 0), uvec2(1, 1), uvec2(0, 1));

vec2 on_circle(uint segment, uint segments) {
  const float angle = kTurn * float(segment % segments) / float(segments);
  return vec2(cos(angle), sin(angle));
}

// Normals of scaled shapes: those of the unit shape divided by its size.
vec3 scaled_normal(vec3 normal, vec3 size) { return normal / max(size, vec3(1e-12)); }

// 36 vertices.
SolidVertex box_vertex(uint vertex, vec3 size) {
  const uint face = vertex / 6, axis = face / 2;
  const float side = face % 2 == 0 ? 1 : -1;
  vec2 corner = vec2(kRectangle[vertex % 6]) * 2 - 1;
  if (side < 0) corner = corner.yx;  // the other winding
  vec3 point = vec3(0), normal = vec3(0);
  point[axis] = side;
  point[(axis + 1) % 3] = corner.x;
  point[(axis + 2) % 3] = corner.y;
  normal[axis] = side;
  return SolidVertex(0.5 * point * size, normal);
}

// 12 vertices per segment: side, top, bottom.
SolidVertex cylinder_vertex(uint vertex, uint segments, vec3 size) {
  const uint segment = vertex / 12, part = vertex % 12;
  if (part < 6) {
    const uvec2 corner = kRectangle[part];
    const vec2 direction = on_circle(segment + corner.x, segments);
    return SolidVertex(0.5 * size * vec3(direction, corner.y * 2.0 - 1), scaled_normal(vec3(direction, 0), size));
  }
  const bool is_top = part < 9;
  const uint corner = part % 3;
  const uint next = is_top ? corner - 1 : 2 - corner;
  const vec2 direction = corner == 0 ? vec2(0) : on_circle(segment + next, segments);
  const float side = is_top ? 1 : -1;
  return SolidVertex(0.5 * size * vec3(direction, side), vec3(0, 0, side));
}

// Sphere or capsule, 6 vertices per segment and ring. A capsule has one ring more, between its halves.
SolidVertex ball_vertex(uint vertex, uint segments, uint rings, vec3 size, bool is_capsule) {
  const uint quad = vertex / 6, segment = quad % segments, ring = quad / segments;
  const uvec2 corner = kRectangle[vertex % 6];
  const uint step = ring + corner.y;  // from the lower pole
  const bool is_upper = is_capsule && step > rings / 2;
  const float angle = kTurn * 0.5 * float(is_upper ? step - 1 : step) / float(rings);
  const vec3 unit = vec3(on_circle(segment + corner.x, segments) * sin(angle), -cos(angle));
  if (!is_capsule) return SolidVertex(0.5 * size * unit, scaled_normal(unit, size));
  const vec3 round_size = vec3(size.xy, 0.5 * (size.x + size.y));
  const vec3 shift = vec3(0, 0, is_upper ? 0.5 * size.z : -0.5 * size.z);
  return SolidVertex(0.5 * round_size * unit + shift, scaled_normal(unit, round_size));
}

// From the origin along z. 15 vertices per segment: shaft, its lower end, head, its base.
SolidVertex arrow_vertex(uint vertex, uint segments, float radius, float length_) {
  const float head_radius = 2 * radius, head_length = min(5 * radius, 0.5 * length_);
  const float neck = length_ - head_length;
  const uint segment = vertex / 15, part = vertex % 15;
  if (part < 6) {
    const uvec2 corner = kRectangle[part];
    const vec2 direction = on_circle(segment + corner.x, segments);
    return SolidVertex(vec3(radius * direction, corner.y * neck), vec3(direction, 0));
  }
  const uint corner = part % 3;
  if (part >= 9 && part < 12) {  // head
    const vec2 direction = on_circle(segment + (corner == 1 ? 1u : 0u), segments);
    const vec3 normal = vec3(direction * head_length, head_radius);
    return SolidVertex(corner == 2 ? vec3(0, 0, length_) : vec3(head_radius * direction, neck), normal);
  }
  const bool is_tail = part < 9;
  const vec2 direction = corner == 0 ? vec2(0) : on_circle(segment + 2 - corner, segments);
  return SolidVertex(vec3((is_tail ? radius : head_radius) * direction, is_tail ? 0 : neck), vec3(0, 0, -1));
}

#endif
