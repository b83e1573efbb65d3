// GPU records of vertices, primitives, primitive instances and clusters.
#ifndef FIRE3DV_SHARED_GEOMETRY_TYPES_H
#define FIRE3DV_SHARED_GEOMETRY_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Records that every pixel reads are laid out for loads of 16 bytes: sizes are multiples, members do not
// cross boundaries, and buffer references declare the alignment. Word-by-word loads would dominate the time.

// scene::TangentFrame and scene::VertexExtras on the GPU, in words.
struct FrameRecord {
  uint normal_xy;
  uint normal_z_tangent_z;
};

struct ExtrasRecord {
  vec2 uv1;
  uint color_rg;
  uint color_ba;
};

struct PrimitiveRecord {
  vec3 mesh_center;  // bounding sphere of the whole mesh, node space
  float mesh_radius;
  uint first_index;
  uint first_vertex;
  uint material;
  uint first_ray_box;  // where rays are traced to boxes
};

// scene::RayAabb on the GPU; vertex and triangle indices are absolute.
struct RayBoxRecord {
  vec3 low, high;
  uint first_vertex;
  uint triangles;  // low bits: first triangle; from FIRE3DV_RAY_BOX_COUNT_SHIFT on: count - 1
};
#define FIRE3DV_RAY_BOX_COUNT_SHIFT 28

// A primitive instance (a primitive at a node), in scene order. Clusters, ids and draws refer to it.
struct PartRecord {
  uint node;
  uint primitive;
  uint flags;
  uint material;
};

#define FIRE3DV_PART_DOUBLE_SIDED 1u
#define FIRE3DV_PART_MASK 2u          // alpha-masked
#define FIRE3DV_PART_FORWARD_ONLY 4u  // blended, lines or points: drawn by the forward pass only
#define FIRE3DV_PART_CLOSED 8u        // see scene::CasterShape
#define FIRE3DV_PART_PLANAR 16u
#define FIRE3DV_PART_DEFORMED 32u  // vertices change: cluster bounds are unknown
#define FIRE3DV_PART_NO_SHADOW 64u
#define FIRE3DV_PART_UNLIT 128u    // lines and points without normals
#define FIRE3DV_PART_COLORED 256u  // has vertex colours other than white

// scene::Cluster on the GPU; vertex and triangle indices are absolute.
struct ClusterRecord {
  vec3 center;
  float radius;
  vec3 cone_axis;
  float cone_cutoff;
  uint first_vertex;
  uint first_triangle;
  uint vertex_count;
  uint triangle_count;
  uint made_by;    // LevelGroupRecord[] index of the group that produced the cluster; FIRE3DV_NO_INDEX: LOD 0
  uint merged_by;  // group that simplified the cluster; FIRE3DV_NO_INDEX: no coarser level
  float surface_error;  // maximum distance to the LOD 0 surface, node space
  uint padding;
};

// scene::LevelGroup on the GPU.
struct LevelGroupRecord {
  vec3 center;
  float radius;
  float error;
  float surface_error;
};

// Cluster of a primitive instance. An id in the visibility buffer is (index + 1) * 128 + triangle. The record
// repeats the fields of instance and cluster that raster and shading need: one read instead of two dependent
// ones.
struct ClusterInstance {
  uint part;
  uint cluster;
  uint node;
  uint first_vertex;
  uint first_triangle;
  uint counts;  // vertices | triangles << 16
};

// One draw of the forward pass.
struct DrawRecord {
  uint node;
  uint primitive;
  uint part;
  uint first_number;  // numbers of its triangles, lines or points in the scene, consecutive
};

FIRE3DV_SHARED_END
#endif
