#ifndef FIRE3DV_JOINT_MATRIX_GLSL
#define FIRE3DV_JOINT_MATRIX_GLSL
#include "common/buffers.glsl"

// Where a joint takes what it moves. To the bit the same for vertices and for the boxes around them.
AffineRows world_from_mesh(DeformPush push, DeformRecord record, uint joint) {
  const JointRecord j = JointRef(push.joints).at[record.first_joint + joint];
  return multiply(AffineRowsRef(push.world_from_node).at[j.node], j.joint_from_mesh);
}

#endif
