// GPU records of skins and morph targets.
#ifndef FIRE3DV_SHARED_DEFORM_TYPES_H
#define FIRE3DV_SHARED_DEFORM_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Up to four joint influences of a vertex, as indices into its skin.
struct InfluenceRecord {
  uint joints_low;  // two 16-bit indices
  uint joints_high;
  vec4 weights;
};

struct JointRecord {
  AffineRows joint_from_mesh;
  uint node;
};

// Bounding box in the space of a skin's joint, or of the mesh's node where joint is FIRE3DV_NO_INDEX.
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

// A primitive instance with deformed vertices of its own.
struct DeformRecord {
  uint node;
  uint primitive;     // of the deformed copy
  uint rest_vertex;   // first source vertex, in the rest pose
  uint posed_vertex;  // first deformed vertex
  uint vertex_count;
  uint first_source;     // per vertex: its index in the scene's original vertex arrays
  uint skinned;          // 1: output in world space; 0: in node space
  float sign_x;          // skinned: -1 where the draw space mirrors world space
  uint first_influence;  // FIRE3DV_NO_INDEX: moves with the node
  uint influence_sets;
  uint first_joint;
  uint first_bounds;  // skinned only
  uint bounds_count;
  uint first_delta;
  uint delta_stride;  // between consecutive targets
  uint target_count;
  uint first_weight;
};

// Range of vertices that one workgroup deforms.
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
  FIRE3DV_ADDRESS tangents;         // uint[], read and written; 0: no tangents
  FIRE3DV_ADDRESS primitives;       // PrimitiveRecord[], bounding spheres written
  uint group_count;                 // workgroups
};

FIRE3DV_SHARED_END
#endif
