// Joint matrices of skinning.
#ifndef FIRE3DV_JOINT_MATRIX_GLSL
#define FIRE3DV_JOINT_MATRIX_GLSL
#include "common/buffers.glsl"

// Transform of a joint's influence. Vertices and their bounding boxes use it, so the results match bit for
// bit.
AffineRows world_from_mesh(DeformPush push, DeformRecord record, uint joint) {
  const JointRecord j = JointRef(push.joints).at[record.first_joint + joint];
  return multiply(AffineRowsRef(push.world_from_node).at[j.node], j.joint_from_mesh);
}

#endif
