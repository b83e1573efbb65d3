// Skins and morph targets.
#ifndef FIRE3DV_SHARED_DEFORM_TYPES_H
#define FIRE3DV_SHARED_DEFORM_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Up to four of the joints that move a vertex, as indices into its skin.
struct InfluenceRecord {
  uint joints_low;  // two 16-bit indices
  uint joints_high;
  vec4 weights;
};

struct JointRecord {
  AffineRows joint_from_mesh;
  uint node;
};

// A box that moves with a joint of the skin, or with the node of the mesh where joint is FIRE3DV_NO_INDEX.
struct JointBoundsRecord {
  uint joint;
  vec3 low;
  vec3 high;
};

struct MorphDeltaRecord {
  vec3 position;
  vec3 normal;
  vec3 tangent;
};

// A primitive at a node, which has a copy of its vertices.
struct DeformRecord {
  uint node;
  uint primitive;     // of the copy
  uint rest_vertex;   // the first one of those that stay as they are
  uint posed_vertex;  // the first one of the copy
  uint vertex_count;
  uint first_source;     // of each vertex: its number in the arrays that the scene has in its own order
  uint skinned;          // 1: written in the world; 0: in the node's frame
  float sign_x;          // skinned ones: -1 where the frame that they are drawn in mirrors the world
  uint first_influence;  // FIRE3DV_NO_INDEX: moves with the node
  uint influence_sets;
  uint first_joint;
  uint first_bounds;  // of skinned ones
  uint bounds_count;
  uint first_delta;
  uint delta_stride;  // from one target to the next
  uint target_count;
  uint first_weight;
};

// What one workgroup deforms.
struct DeformGroup {
  uint record;
  uint first_vertex;
};

struct DeformPush {
  FIRE3DV_ADDRESS records;          // DeformRecord[]
  FIRE3DV_ADDRESS groups;           // DeformGroup[]
  FIRE3DV_ADDRESS sources;          // uint[]
  FIRE3DV_ADDRESS influences;       // InfluenceRecord[]
  FIRE3DV_ADDRESS joints;           // JointRecord[]
  FIRE3DV_ADDRESS joint_bounds;     // JointBoundsRecord[]
  FIRE3DV_ADDRESS deltas;           // MorphDeltaRecord[]
  FIRE3DV_ADDRESS weights;          // float[]
  FIRE3DV_ADDRESS world_from_node;  // AffineRows[]
  FIRE3DV_ADDRESS positions;        // vec3[], read and written
  FIRE3DV_ADDRESS frames;           // FrameRecord[], read and written
  FIRE3DV_ADDRESS tangents;         // uint[], read and written; 0: there are none
  FIRE3DV_ADDRESS primitives;       // PrimitiveRecord[], spheres written
  uint group_count;                 // of workgroups
};

FIRE3DV_SHARED_END
#endif
