// From an id of the visibility buffer to the triangle, and to the point of it that a pixel shows.
#ifndef FIRE3DV_VISIBLE_TRIANGLE_GLSL
#define FIRE3DV_VISIBLE_TRIANGLE_GLSL
#include "common/raster_rules.glsl"
#include "common/surface_point.glsl"
#include "common/textures.glsl"

struct VisibleTriangle {
  PartRecord part;
  uint material;
  uint vertex[3];
  vec3 world[3];
  vec4 clip[3];
  AffineRows world_from_node;
};

uint part_of_id(GlobalsRef globals, uint id) {
  return ClusterInstanceRef(globals.value.cluster_instances).at[(id >> 7) - 1].part;
}

VisibleTriangle visible_triangle(GlobalsRef globals, uint id) {
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[(id >> 7) - 1];
  const uint triangle = ClusterRef(globals.value.clusters).at[instance.cluster].first_triangle + (id & 127);
  VisibleTriangle t;
  t.part = PartRef(globals.value.parts).at[instance.part];
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[t.part.primitive];
  t.material = primitive.material;
  t.world_from_node = AffineRowsRef(globals.value.world_from_node).at[t.part.node];
  UintRef indices = UintRef(globals.value.indices);
  PositionRef positions = PositionRef(globals.value.positions);
  for (int i = 0; i < 3; ++i) {
    t.vertex[i] = primitive.first_vertex + indices.at[3 * triangle + i];
    t.world[i] = world_position(t.world_from_node, positions.at[t.vertex[i]]);
    t.clip[i] = clip_position(globals.value.clip_from_world, t.world[i]);
  }
  return t;
}

// Of the point that is seen at a place of the image, in pixels. Perspective-correct, from homogeneous coordinates: a
// corner may lie behind the eye.
vec3 barycentrics_at(VisibleTriangle t, vec2 pixel, vec2 size) {
  const vec2 ndc = pixel / size * 2 - 1;
  const vec2 a = t.clip[0].xy - ndc * t.clip[0].w;
  const vec2 b = t.clip[1].xy - ndc * t.clip[1].w;
  const vec2 c = t.clip[2].xy - ndc * t.clip[2].w;
  const vec3 weight = vec3(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
  const float sum = weight.x + weight.y + weight.z;
  return sum != 0 ? weight / sum : vec3(1, 0, 0);
}

// Weights of a point in the triangle: rounding puts that of a tiny triangle far outside.
vec3 inside(vec3 barycentrics) {
  const vec3 b = max(barycentrics, vec3(0));
  return b / (b.x + b.y + b.z);
}

// How barycentrics change from a pixel's middle to the next one's, right and down: within blocks of 2 x 2 pixels, as the
// raster pipeline finds derivatives, so that both choose the same texels.
void barycentric_changes(VisibleTriangle t, vec2 place, vec2 size, out vec3 dx, out vec3 dy) {
  const vec2 middle = floor(place) + 0.5;
  const vec2 step = vec2(1) - 2 * mod(floor(place), vec2(2));  // to the other pixel of the block
  const vec3 here = barycentrics_at(t, middle, size);
  dx = (barycentrics_at(t, middle + vec2(step.x, 0), size) - here) * step.x;
  dy = (barycentrics_at(t, middle + vec2(0, step.y), size) - here) * step.y;
}

vec4 uv_at(VertexRecord v[3], vec3 b) {
  return vec4(v[0].uv0, v[0].uv1) * b.x + vec4(v[1].uv0, v[1].uv1) * b.y + vec4(v[2].uv0, v[2].uv1) * b.z;
}

SurfacePoint surface_point(GlobalsRef globals, VisibleTriangle t, vec2 pixel) {
  const vec2 size = vec2(globals.value.width, globals.value.height);
  const vec3 b = inside(barycentrics_at(t, pixel, size));
  vec3 b_dx, b_dy;
  barycentric_changes(t, pixel, size, b_dx, b_dy);
  VertexRecord v[3];
  for (int i = 0; i < 3; ++i) v[i] = VertexRef(globals.value.vertices).at[t.vertex[i]];

  SurfacePoint point;
  point.material = t.material;
  point.position_world = t.world[0] * b.x + t.world[1] * b.y + t.world[2] * b.z;
  const vec3 along_x = t.world[0] * b_dx.x + t.world[1] * b_dx.y + t.world[2] * b_dx.z;
  const vec3 along_y = t.world[0] * b_dy.x + t.world[1] * b_dy.y + t.world[2] * b_dy.z;
  point.pixel_size_m = min(length(along_x), length(along_y));
  point.uv = uv_at(v, b);
  point.uv_dx = uv_at(v, b_dx);
  point.uv_dy = uv_at(v, b_dy);
  point.color = v[0].color * b.x + v[1].color * b.y + v[2].color * b.z;
  point.normal_world = normalize(
      transform_normal(t.world_from_node, v[0].normal * b.x + v[1].normal * b.y + v[2].normal * b.z));
  const vec4 tangent = v[0].tangent * b.x + v[1].tangent * b.y + v[2].tangent * b.z;
  point.tangent_world = vec4(transform_direction(t.world_from_node, tangent.xyz), tangent.w);

  // Which side is seen follows from the winding, as for the raster pipeline; a reflection swaps the sides.
  vec3 plane = cross(t.world[1] - t.world[0], t.world[2] - t.world[0]);
  const vec3 r0 = t.world_from_node.row0.xyz, r1 = t.world_from_node.row1.xyz, r2 = t.world_from_node.row2.xyz;
  if (dot(r0, cross(r1, r2)) < 0) plane = -plane;
  plane = dot(plane, plane) > 0 ? normalize(plane) : point.normal_world;
  // A surface with one side shows that one. Of one with two, the ray through the pixel tells.
  const vec2 ndc = pixel / size * 2 - 1;
  const vec3 look = globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
                    globals.value.world_from_ndc_origin;
  const bool from_behind = (t.part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0 && dot(plane, look) > 0;
  point.plane_normal_world = from_behind ? -plane : plane;
  if (from_behind) point.normal_world = -point.normal_world;
  return point;
}

// The test of an alpha-masked surface at a place of an image of this size.
bool is_solid_at(GlobalsRef globals, VisibleTriangle t, vec2 pixel, vec2 size) {
  const vec3 b = inside(barycentrics_at(t, pixel, size));
  VertexRecord v[3];
  for (int i = 0; i < 3; ++i) v[i] = VertexRef(globals.value.vertices).at[t.vertex[i]];
  const vec4 uv = uv_at(v, b);
  vec3 b_dx, b_dy;
  barycentric_changes(t, pixel, size, b_dx, b_dy);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[t.material];
  const float vertex_alpha = v[0].color.a * b.x + v[1].color.a * b.y + v[2].color.a * b.z;
  const float alpha = material.base_color.a * vertex_alpha * sample_or(material.base_color_texture, uv, uv_at(v, b_dx), uv_at(v, b_dy), vec4(1)).a;
  return alpha >= material.alpha_cutoff;
}

#endif
