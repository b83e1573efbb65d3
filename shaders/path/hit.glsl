// Hits of path rays: acceptance of candidates, and the surface point of the closest one.
#ifndef FIRE3DV_HIT_GLSL
#define FIRE3DV_HIT_GLSL
#include "common/buffers.glsl"
#include "path/random.glsl"
#include "shading/masked_hit.glsl"
#include "common/surface_point.glsl"

// Closest hit of a ray.
struct Hit {
  bool found;
  uint node, geometry, triangle;
  vec2 barycentrics;
  mat4x3 world_from_object;
};

PrimitiveRecord primitive_of_hit(GlobalsRef globals, uint node, uint geometry) {
  const uint index = UintRef(globals.value.first_primitive_of_node).at[node] + geometry;
  return PrimitiveRef(globals.value.primitives).at[index];
}

uint vertex_of(GlobalsRef globals, PrimitiveRecord primitive, uint triangle, uint corner) {
  return primitive.first_vertex + UintRef(globals.value.indices).at[primitive.first_index + 3 * triangle + corner];
}

// Camera rays pass the back of single-sided surfaces, as in the raster, but not of volumes; all other rays meet both
// sides. A blended
// surface stops the share `alpha` of the rays, chosen by a hash of ray and triangle, so that the order of candidates
// does not matter. ray_random: of the ray.
bool accepts_hit(GlobalsRef globals, uint node, uint geometry, uint triangle, vec2 barycentrics,
                 vec3 object_direction, bool is_camera_ray, uvec4 ray_random) {
  const PrimitiveRecord primitive = primitive_of_hit(globals, node, geometry);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  if (is_camera_ray && (material.flags & (FIRE3DV_MATERIAL_DOUBLE_SIDED | FIRE3DV_MATERIAL_VOLUME)) == 0) {
    PositionRef positions = PositionRef(globals.value.positions);
    const vec3 a = positions.at[vertex_of(globals, primitive, triangle, 0)];
    const vec3 b = positions.at[vertex_of(globals, primitive, triangle, 1)];
    const vec3 c = positions.at[vertex_of(globals, primitive, triangle, 2)];
    if (dot(cross(b - a, c - a), object_direction) >= 0) return false;
  }
  if ((material.flags & (FIRE3DV_MATERIAL_MASK | FIRE3DV_MATERIAL_BLEND)) == 0) return true;
  const float alpha = alpha_of_hit(globals, primitive, material, triangle, barycentrics);
  if ((material.flags & FIRE3DV_MATERIAL_MASK) != 0) return alpha >= material.alpha_cutoff;
  return unit_numbers(pcg4d(ray_random ^ uvec4(node, geometry, triangle, 0))).x < alpha;
}

struct PathVertex {
  SurfacePoint point;
  bool is_back;       // of a surface
  float rounding_m;   // of positions on the triangle
};

PathVertex path_vertex(GlobalsRef globals, Hit hit, PrimitiveRecord primitive, MaterialRecord material,
                       vec3 direction) {
  const vec3 b = vec3(1 - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics);
  const mat4x3 m = hit.world_from_object;
  const AffineRows world_from_object = AffineRows(vec4(m[0].x, m[1].x, m[2].x, m[3].x), vec4(m[0].y, m[1].y, m[2].y, m[3].y),
                                                  vec4(m[0].z, m[1].z, m[2].z, m[3].z));
  ExtrasRef extras = ExtrasRef(globals.value.extras);
  UintRef tangents = UintRef(globals.value.tangents);
  PathVertex vertex;
  SurfacePoint point;
  point.material = primitive.material;
  point.uv = point.uv_dx = point.uv_dy = vec4(0);  // zero derivatives select mip level 0
  point.pixel_size_m = 0;
  point.lift_m = 0;
  point.color = vec4(0);
  point.position_world = vec3(0);
  vec3 corner[3], corner_normal[3], normal = vec3(0);
  vec4 tangent = vec4(0);
  vertex.rounding_m = 0;
  for (int i = 0; i < 3; ++i) {
    const uint v = vertex_of(globals, primitive, hit.triangle, i);
    corner[i] = transform_point(world_from_object, PositionRef(globals.value.positions).at[v]);
    point.position_world += b[i] * corner[i];
    vertex.rounding_m = max(vertex.rounding_m, max(abs(corner[i].x), max(abs(corner[i].y), abs(corner[i].z))));
    const FrameRecord frame = FrameRef(globals.value.frames).at[v];
    normal += b[i] * normal_of(frame);
    corner_normal[i] = transform_normal(world_from_object, normal_of(frame));
    if (kTextures && (material.flags & FIRE3DV_MATERIAL_NORMAL_MAPPED) != 0)
      tangent += b[i] * tangent_of(frame, tangent_xy_of(tangents, v));
    if (kTextures && (material.flags & FIRE3DV_MATERIAL_TEXTURED) != 0)
      point.uv += b[i] * vec4(UvRef(globals.value.uvs).at[v], uv1_of(extras, v));
    point.color += b[i] * color_of(extras, v);
  }
  vertex.rounding_m /= 2097152.0;  // 2^21
  const vec3 world_normal = transform_normal(world_from_object, normal);
  point.normal_world = normalize(world_normal);
  point.tangent_world = vec4(transform_direction(world_from_object, tangent.xyz), tangent.w);
  vec3 plane = cross(corner[1] - corner[0], corner[2] - corner[0]);
  if (is_mirroring(world_from_object)) plane = -plane;
  plane = dot(plane, plane) > 0 ? normalize(plane) : point.normal_world;
  vertex.is_back = dot(plane, direction) > 0;
  point.plane_normal_world = vertex.is_back ? -plane : plane;
  if (vertex.is_back) point.normal_world = -point.normal_world;
  point.smooth_height_m = 0;
  if ((material.flags & FIRE3DV_MATERIAL_PASSES_LIGHT) == 0)
    point.smooth_height_m = smooth_height(corner, corner_normal, b, vertex.is_back) / length(world_normal);
  vertex.point = point;
  return vertex;
}

#endif
