// GPU records of pose sources and parameters of the transforms pass.
#ifndef FIRE3DV_SHARED_POSE_TYPES_H
#define FIRE3DV_SHARED_POSE_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Pose source of one node. See state::NodeDrive.
struct NodeSource {
  AffineRows body_from_node;  // world_from_node at rest when stream is FIRE3DV_NO_INDEX
  uint stream;
  uint pose_index;
};

struct StreamSource {
  FIRE3DV_ADDRESS poses;  // AffineRows[], stream_from_body
  AffineRows world_from_stream;
};

struct TransformsPush {
  FIRE3DV_ADDRESS sources;           // NodeSource[]
  FIRE3DV_ADDRESS streams;           // StreamSource[]
  FIRE3DV_ADDRESS world_from_node;   // AffineRows[], written
  FIRE3DV_ADDRESS instance_of_node;  // uint[]
  FIRE3DV_ADDRESS instances;         // VkAccelerationStructureInstanceKHR[], transforms written; 0: none
  FIRE3DV_ADDRESS node_facts;        // uint[]: FIRE3DV_NODE_*, written
  FIRE3DV_ADDRESS light_of_node;     // uint[]
  FIRE3DV_ADDRESS lights;            // LightRecord[]
  FIRE3DV_ADDRESS light_poses;       // LightPose[], written
  uint node_count;
};

#define FIRE3DV_NODE_MIRRORED 1u  // negative determinant
#define FIRE3DV_NODE_EVEN 2u      // uniform scale

FIRE3DV_SHARED_END
#endif
