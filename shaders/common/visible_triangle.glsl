// Reconstruction of the triangle and the surface point of a pixel from its visibility buffer id.
#ifndef FIRE3DV_VISIBLE_TRIANGLE_GLSL
#define FIRE3DV_VISIBLE_TRIANGLE_GLSL
#include "visibility/raster_rules.glsl"
#include "common/surface_point.glsl"
#include "common/textures.glsl"
#include "common/vertices.glsl"

struct VisibleTriangle {
  PartRecord part;
  uint material;
#ifdef FIRE3DV_CPU
  MaterialRecord material_record;
  bool for_all;  // all lanes are active and show this triangle
#else
  // Vertex attributes, read together with the positions to overlap their latencies. The compiler removes
  // unused reads.
  FrameRecord frame[3];
  uint tangent_xy[3];
  vec2 uv0[3];
#endif
  uint vertex[3];
  vec3 world[3];
  vec4 clip[3];
  AffineRows world_from_node;
  uint node_facts;
  float surface_error;  // node space
};

uint part_of_id(GlobalsRef globals, uint id) {
  return ClusterInstanceRef(globals.value.cluster_instances).at[(id >> 7) - 1].part;
}

// Reads the primitive instance of a triangle.
void read_part(GlobalsRef globals, ClusterInstance instance, inout VisibleTriangle t) {
  t.part = PartRef(globals.value.parts).at[instance.part];
  t.material = t.part.material;
  t.world_from_node = AffineRowsRef(globals.value.world_from_node).at[instance.node];
  t.node_facts = UintRef(globals.value.node_facts).at[instance.node];
#ifdef FIRE3DV_CPU
  t.material_record = MaterialRef(globals.value.materials).at[t.material];
#endif
}

void place_corners(GlobalsRef globals, inout VisibleTriangle t, vec3 a, vec3 b, vec3 c) {
  const vec3 node[3] = vec3[3](a, b, c);
  for (int i = 0; i < 3; ++i) {
    t.world[i] = world_position(t.world_from_node, node[i]);
    t.clip[i] = clip_position(globals.value.clip_from_world, t.world[i]);
  }
}

#ifdef FIRE3DV_CPU
// The same with all lanes active: neighbours mostly show the same primitive instance.
void read_part_together(GlobalsRef globals, ClusterInstance instance, inout VisibleTriangle t) {
  const uint first = subgroupBroadcast(instance.part, 0);
  t.part = part_for_all(globals.value.parts, first);
  t.material = t.part.material;
  t.world_from_node = affine_for_all(globals.value.world_from_node, t.part.node);
  t.node_facts = UintRef(globals.value.node_facts).at[t.part.node];
  t.material_record = material_for_all(globals.value.materials, t.material);
  if (instance.part != first) read_part(globals, instance, t);
}

// All lanes show one large triangle, which is read once.
VisibleTriangle triangle_for_all(GlobalsRef globals, uint id) {
  const ClusterInstance instance = instance_for_all(globals.value.cluster_instances, (id >> 7) - 1);
  const uint packed = UintRef(globals.value.cluster_triangles).at[instance.first_triangle + (id & 127)];
  VisibleTriangle t;
  t.for_all = true;
  t.surface_error = ClusterRef(globals.value.clusters).at[instance.cluster].surface_error;
  read_part_together(globals, instance, t);
  for (int i = 0; i < 3; ++i) t.vertex[i] = instance.first_vertex + ((packed >> (8 * i)) & 255);
  vec3 node[3];
  positions_for_all(globals.value.positions, t.vertex, node);
  place_corners(globals, t, node[0], node[1], node[2]);
  return t;
}

MaterialRecord material_of(GlobalsRef globals, VisibleTriangle t) { return t.material_record; }

// Reads on demand: on a CPU the number of reads matters, not their latency.
FrameRecord frame_of(GlobalsRef globals, VisibleTriangle t, int corner) { return FrameRef(globals.value.frames).at[t.vertex[corner]]; }
uint tangent_xy_of(GlobalsRef globals, VisibleTriangle t, int corner) {
  return tangent_xy_of(UintRef(globals.value.tangents), t.vertex[corner]);
}
vec2 uv0_of(GlobalsRef globals, VisibleTriangle t, int corner) { return UvRef(globals.value.uvs).at[t.vertex[corner]]; }
#else
MaterialRecord material_of(GlobalsRef globals, VisibleTriangle t) { return MaterialRef(globals.value.materials).at[t.material]; }

void read_corners(GlobalsRef globals, inout VisibleTriangle t) {
  const bool turned = kTextures && globals.value.tangents != 0;
  for (int i = 0; i < 3; ++i) {
    t.frame[i] = FrameRef(globals.value.frames).at[t.vertex[i]];
    t.uv0[i] = kTextures ? UvRef(globals.value.uvs).at[t.vertex[i]] : vec2(0);
    t.tangent_xy[i] = turned ? UintRef(globals.value.tangents).at[t.vertex[i]] : FIRE3DV_NO_TANGENT;
  }
}

FrameRecord frame_of(GlobalsRef globals, VisibleTriangle t, int corner) { return t.frame[corner]; }
uint tangent_xy_of(GlobalsRef globals, VisibleTriangle t, int corner) { return t.tangent_xy[corner]; }
vec2 uv0_of(GlobalsRef globals, VisibleTriangle t, int corner) { return t.uv0[corner]; }
#endif

// together: all lanes are active.
VisibleTriangle own_triangle(GlobalsRef globals, uint id, const bool together) {
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[(id >> 7) - 1];
  const uint packed = UintRef(globals.value.cluster_triangles).at[instance.first_triangle + (id & 127)];
  VisibleTriangle t;
  t.surface_error = ClusterRef(globals.value.clusters).at[instance.cluster].surface_error;
#ifdef FIRE3DV_CPU
  t.for_all = false;
  if (together) {
    read_part_together(globals, instance, t);
  } else
#endif
    read_part(globals, instance, t);
  for (int i = 0; i < 3; ++i) t.vertex[i] = instance.first_vertex + ((packed >> (8 * i)) & 255);
#ifndef FIRE3DV_CPU
  read_corners(globals, t);
#endif
  PositionRef positions = PositionRef(globals.value.positions);
  place_corners(globals, t, positions.at[t.vertex[0]], positions.at[t.vertex[1]], positions.at[t.vertex[2]]);
  return t;
}

VisibleTriangle visible_triangle(GlobalsRef globals, uint id, const bool together) {
#ifdef FIRE3DV_CPU
  VisibleTriangle t;
  if (together && all_lanes_have(id)) {
    t = triangle_for_all(globals, id);
  } else {
    t = own_triangle(globals, id, together);
  }
  return t;
#else
  return own_triangle(globals, id, together);
#endif
}

VisibleTriangle visible_triangle(GlobalsRef globals, uint id) { return visible_triangle(globals, id, false); }

// Replaces clip positions by those of another view, for alpha tests.
VisibleTriangle seen_from(VisibleTriangle t, RasterView view) {
  for (int i = 0; i < 3; ++i) t.clip[i] = clip_position(view.clip_from_world, t.world[i]);
  return t;
}

// Perspective-correct barycentrics at an image position in pixels, from homogeneous coordinates: a vertex may
// lie behind the eye.
vec3 barycentrics_at(VisibleTriangle t, vec2 pixel, vec2 size) {
  const vec2 ndc = pixel / size * 2 - 1;
  const vec2 a = t.clip[0].xy - ndc * t.clip[0].w;
  const vec2 b = t.clip[1].xy - ndc * t.clip[1].w;
  const vec2 c = t.clip[2].xy - ndc * t.clip[2].w;
  const vec3 weight = vec3(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
  const float sum = weight.x + weight.y + weight.z;
  return sum != 0 ? weight / sum : vec3(1, 0, 0);
}

// Clamps barycentrics to the triangle, since rounding may put those of a tiny triangle far outside.
vec3 inside(vec3 barycentrics) {
  const vec3 b = max(barycentrics, vec3(0));
  return b / (b.x + b.y + b.z);
}

// Limits barycentrics to about one triangle size outside, as needed where the triangle represents merged
// neighbours.
vec3 nearby(vec3 barycentrics) {
  const vec3 from_center = barycentrics - 1.0 / 3;
  const vec3 size = abs(from_center);
  return from_center * min(1, 2 / max(size.x, max(size.y, size.z))) + 1.0 / 3;
}

// Derivatives of barycentrics within blocks of 2 x 2 pixels, as in the raster pipeline, so that both select
// the same mip levels.
void barycentric_changes(VisibleTriangle t, vec2 position, vec2 size, out vec3 dx, out vec3 dy) {
  const vec2 center = floor(position) + 0.5;
  const vec2 step = vec2(1) - 2 * mod(floor(position), vec2(2));  // to the other pixel of the block
  const vec3 here = barycentrics_at(t, center, size);
  dx = (barycentrics_at(t, center + vec2(step.x, 0), size) - here) * step.x;
  dy = (barycentrics_at(t, center + vec2(0, step.y), size) - here) * step.y;
}

// Texture coordinates of the vertices; the second set is read only if a texture uses it.
struct TriangleUv {
  vec4 at[3];
};

TriangleUv triangle_uv(GlobalsRef globals, VisibleTriangle t, uint material_flags) {
  const bool second = kSecondUv && (material_flags & FIRE3DV_MATERIAL_SECOND_UV) != 0;
  TriangleUv uv;
  for (int i = 0; i < 3; ++i) {
    uv.at[i] = vec4(uv0_of(globals, t, i),
                    second ? uv1_of(ExtrasRef(globals.value.extras), t.vertex[i]) : vec2(0));
  }
  return uv;
}

vec4 uv_at(TriangleUv uv, vec3 b) {
  if (!kSecondUv) return vec4(uv.at[0].xy * b.x + uv.at[1].xy * b.y + uv.at[2].xy * b.z, 0, 0);
  return uv.at[0] * b.x + uv.at[1] * b.y + uv.at[2] * b.z;
}

vec4 color_at(GlobalsRef globals, VisibleTriangle t, vec3 b) {
  if ((t.part.flags & FIRE3DV_PART_COLORED) == 0) return vec4(1);
  ExtrasRef extras = ExtrasRef(globals.value.extras);
  return color_of(extras, t.vertex[0]) * b.x + color_of(extras, t.vertex[1]) * b.y + color_of(extras, t.vertex[2]) * b.z;
}

// Tangent frames of the vertices.
struct TriangleFrames {
  FrameRecord at[3];
};

TriangleFrames triangle_frames(GlobalsRef globals, VisibleTriangle t) {
  TriangleFrames frames;
  for (int i = 0; i < 3; ++i) frames.at[i] = frame_of(globals, t, i);
  return frames;
}

vec3 normal_at(TriangleFrames frames, vec3 b) {
  return (long_normal(frames.at[0]) * b.x + long_normal(frames.at[1]) * b.y + long_normal(frames.at[2]) * b.z) *
         (1 / FIRE3DV_DIRECTION_STEPS);
}

// True if all vertex normals are equal.
bool is_flat(TriangleFrames frames) {
  const uvec3 xy = uvec3(frames.at[0].normal_xy, frames.at[1].normal_xy, frames.at[2].normal_xy);
  const uvec3 z = uvec3(frames.at[0].normal_z_tangent_z, frames.at[1].normal_z_tangent_z, frames.at[2].normal_z_tangent_z) & 0xffffu;
  return xy.x == xy.y && xy.x == xy.z && z.x == z.y && z.x == z.z;
}

vec4 tangent_at(GlobalsRef globals, VisibleTriangle t, TriangleFrames frames, vec3 b) {
  return tangent_of(frames.at[0], tangent_xy_of(globals, t, 0)) * b.x +
         tangent_of(frames.at[1], tangent_xy_of(globals, t, 1)) * b.y +
         tangent_of(frames.at[2], tangent_xy_of(globals, t, 2)) * b.z;
}

#ifdef FIRE3DV_CPU
// The same where all lanes show one triangle.
TriangleUv triangle_uv_for_all(GlobalsRef globals, VisibleTriangle t, uint material_flags) {
  uvec2 first[3], second[3] = uvec2[3](uvec2(0), uvec2(0), uvec2(0));
  pairs_for_all(globals.value.uvs, 2, t.vertex, first);
  if (kSecondUv && (material_flags & FIRE3DV_MATERIAL_SECOND_UV) != 0 && globals.value.extras != 0)
    pairs_for_all(globals.value.extras, 4, t.vertex, second);
  TriangleUv uv;
  for (int i = 0; i < 3; ++i) uv.at[i] = vec4(uintBitsToFloat(first[i]), uintBitsToFloat(second[i]));
  return uv;
}

TriangleFrames triangle_frames_for_all(GlobalsRef globals, VisibleTriangle t) {
  uvec2 words[3];
  pairs_for_all(globals.value.frames, 2, t.vertex, words);
  TriangleFrames frames;
  for (int i = 0; i < 3; ++i) frames.at[i] = FrameRecord(words[i].x, words[i].y);
  return frames;
}
#endif

SurfacePoint surface_point(GlobalsRef globals, VisibleTriangle t, vec2 pixel) {
  const vec2 size = vec2(globals.value.width, globals.value.height);
  const vec3 b = nearby(barycentrics_at(t, pixel, size));
  const uint flags = material_of(globals, t).flags;
  vec3 b_dx = vec3(0), b_dy = vec3(0);
// On a CPU the branch costs less than the derivatives; only shaders that trace need the pixel's size.
#if defined(FIRE3DV_CPU) && !defined(FIRE3DV_TEST_MAPS)
  if (kTextures && (flags & FIRE3DV_MATERIAL_TEXTURED) != 0)
#endif
    barycentric_changes(t, pixel, size, b_dx, b_dy);

  SurfacePoint point;
  point.material = t.material;
  point.position_world = t.world[0] * b.x + t.world[1] * b.y + t.world[2] * b.z;
  const vec3 along_x = t.world[0] * b_dx.x + t.world[1] * b_dx.y + t.world[2] * b_dx.z;
  const vec3 along_y = t.world[0] * b_dy.x + t.world[1] * b_dy.y + t.world[2] * b_dy.z;
  point.pixel_size_m = min(length(along_x), length(along_y));
  // Factor 2 covers error between the sampled positions of the simplification.
  point.lift_m = t.surface_error > 0 ? 2 * t.surface_error * largest_stretch(t.world_from_node) : 0;
  point.uv = point.uv_dx = point.uv_dy = vec4(0);
  TriangleUv uv;
  TriangleFrames frames;
  const bool textured = kTextures && (flags & FIRE3DV_MATERIAL_TEXTURED) != 0;
#ifdef FIRE3DV_CPU
  if (t.for_all) {
    if (textured) uv = triangle_uv_for_all(globals, t, flags);
    frames = triangle_frames_for_all(globals, t);
  } else
#endif
  {
    if (textured) uv = triangle_uv(globals, t, flags);
    frames = triangle_frames(globals, t);
  }
  if (textured) {
    point.uv = uv_at(uv, b);
    point.uv_dx = uv_at(uv, b_dx);
    point.uv_dy = uv_at(uv, b_dy);
  }
  point.color = color_at(globals, t, b);
  const vec3 normal = normal_direction(t.world_from_node, t.node_facts, normal_at(frames, b));
  point.normal_world = normalize(normal);
  point.tangent_world = vec4(0);
  if (kTextures && (flags & FIRE3DV_MATERIAL_NORMAL_MAPPED) != 0) {
    const vec4 tangent = tangent_at(globals, t, frames, b);
    point.tangent_world = vec4(transform_direction(t.world_from_node, tangent.xyz), tangent.w);
  }

  // The winding determines the visible side, as in the raster pipeline; a reflection swaps sides.
  vec3 plane = cross(t.world[1] - t.world[0], t.world[2] - t.world[0]);
  if ((t.node_facts & FIRE3DV_NODE_MIRRORED) != 0) plane = -plane;
  plane = dot(plane, plane) > 0 ? normalize(plane) : point.normal_world;
  // Single-sided surfaces show their front. For double-sided ones the view ray decides.
  const vec2 ndc = pixel / size * 2 - 1;
  const vec3 look = globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
                    globals.value.world_from_ndc_origin;
  const bool is_back_face = (t.part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0 && dot(plane, look) > 0;
  point.plane_normal_world = is_back_face ? -plane : plane;
  if (is_back_face) point.normal_world = -point.normal_world;
  point.smooth_height_m = 0;
  if ((flags & FIRE3DV_MATERIAL_PASSES_LIGHT) == 0 && !is_flat(frames)) {
    vec3 normals[3];
    for (int i = 0; i < 3; ++i)
      normals[i] = normal_direction(t.world_from_node, t.node_facts, long_normal(frames.at[i]) * (1 / FIRE3DV_DIRECTION_STEPS));
    point.smooth_height_m = smooth_height(t.world, normals, b, is_back_face) / length(normal);
  }
  return point;
}

// Alpha test at a position of an image of this size.
bool is_solid_at(GlobalsRef globals, VisibleTriangle t, vec2 pixel, vec2 size) {
  const vec3 b = inside(barycentrics_at(t, pixel, size));
  vec3 b_dx, b_dy;
  barycentric_changes(t, pixel, size, b_dx, b_dy);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[t.material];
  const TriangleUv uv = triangle_uv(globals, t, material.flags);
  const float alpha =
      material.base_color.a * color_at(globals, t, b).a *
      sample_or(material.base_color_texture, uv_at(uv, b), uv_at(uv, b_dx), uv_at(uv, b_dy), vec4(1)).a;
  return alpha >= material.alpha_cutoff;
}

#endif
