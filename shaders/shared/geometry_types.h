// Vertices, primitives, the parts of a scene and their clusters.
#ifndef FIRE3DV_SHARED_GEOMETRY_TYPES_H
#define FIRE3DV_SHARED_GEOMETRY_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// What every pixel reads lies so that it is loaded 16 bytes at a time: structures of their multiples, members
// that do not cross them, buffer references that say so. Word by word the loads alone would be most of the
// time.
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
  vec3 mesh_center;  // sphere around the whole mesh, node space
  float mesh_radius;
  uint first_index;
  uint first_vertex;
  uint material;
  uint first_ray_box;  // where rays are traced to boxes
};

// scene::RayBox on the GPU; vertices and triangles are absolute.
struct RayBoxRecord {
  vec3 low, high;
  uint first_vertex;
  uint triangles;  // the first one; above FIRE3DV_RAY_BOX_COUNT_SHIFT how many, less one
};
#define FIRE3DV_RAY_BOX_COUNT_SHIFT 28

// A primitive at a node, in the order of the scene: what clusters, ids and draws refer to.
struct PartRecord {
  uint node;
  uint primitive;
  uint flags;
  uint material;
};

#define FIRE3DV_PART_DOUBLE_SIDED 1u
#define FIRE3DV_PART_MASK 2u    // alpha-masked
#define FIRE3DV_PART_ON_TOP 4u  // blended, or not of triangles: drawn by the forward pass alone
#define FIRE3DV_PART_CLOSED 8u  // see scene::CasterShape
#define FIRE3DV_PART_PLANAR 16u
#define FIRE3DV_PART_DEFORMED 32u  // vertices change: bounds are not known
#define FIRE3DV_PART_NO_SHADOW 64u
#define FIRE3DV_PART_UNLIT 128u    // lines and points without normals
#define FIRE3DV_PART_COLORED 256u  // has vertices of another colour than white

// scene::Cluster on the GPU; vertices and triangles are absolute.
struct ClusterRecord {
  vec3 center;
  float radius;
  vec3 cone_axis;
  float cone_cutoff;
  uint first_vertex;
  uint first_triangle;
  uint vertex_count;
  uint triangle_count;
  uint made_by;         // of levels of detail: into LevelGroupRecord[]; FIRE3DV_NO_INDEX = the file's own
  uint merged_by;       // FIRE3DV_NO_INDEX = there is nothing coarser
  float surface_error;  // how far this surface may be from the file's own, node space
  uint padding;
};

// scene::LevelGroup on the GPU.
struct LevelGroupRecord {
  vec3 center;
  float radius;
  float error;
  float surface_error;
};

// A cluster of a part. Its number, plus one and times 128, plus the triangle is the id in the visibility
// buffer. What drawing and shading need of the part and the cluster is repeated here, so that they wait for one read instead of
// two, one after the other.
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
};

FIRE3DV_SHARED_END
#endif
