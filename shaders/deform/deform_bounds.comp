// Bounding spheres of skinned primitives, one workgroup each. Vertices lie in the convex hull of the
// transformed joint boxes, so the pass reads no vertices.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/joint_matrix.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { DeformPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer JointBoundsRef { JointBoundsRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer PrimitivesOut { PrimitiveRecord at[]; };

shared vec3 low_of_thread[64];
shared vec3 high_of_thread[64];

const float kRounding = 1.0 / 262144.0;  // relative to the largest number in a sum: 2^-18

void main() {
  const uint index = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (index >= push.group_count) return;
  const DeformRecord record = DeformRecordRef(push.records).at[index];
  if (record.skinned == 0) return;  // uniform for the group; bounds of morphed primitives hold for all
                                    // weights
  vec3 low = vec3(3e38), high = vec3(-3e38);
  for (uint i = gl_LocalInvocationIndex; i < record.bounds_count; i += 64) {
    const JointBoundsRecord box = JointBoundsRef(push.joint_bounds).at[record.first_bounds + i];
    AffineRows m;
    if (box.joint == FIRE3DV_NO_INDEX) {
      m = AffineRowsRef(push.world_from_node).at[record.node];
    } else {
      m = world_from_mesh(push, record, box.joint);
    }
    const vec3 box_center = 0.5 * (box.low + box.high), half_size = 0.5 * (box.high - box.low);
    const vec3 center = transform_point(m, box_center);
    const vec4 reach = vec4(abs(box_center) + half_size, 1), size = vec4(half_size, 0);
    const vec3 largest = vec3(dot(abs(m.row0), reach), dot(abs(m.row1), reach), dot(abs(m.row2), reach));
    const vec3 extent = vec3(dot(abs(m.row0), size), dot(abs(m.row1), size), dot(abs(m.row2), size)) + kRounding * largest;
    if (any(isnan(center + extent)) || any(isinf(center + extent))) continue;
    low = min(low, center - extent);
    high = max(high, center + extent);
  }
  low_of_thread[gl_LocalInvocationIndex] = low;
  high_of_thread[gl_LocalInvocationIndex] = high;
  barrier();
  for (uint step = 32; step > 0; step /= 2) {
    if (gl_LocalInvocationIndex < step) {
      low_of_thread[gl_LocalInvocationIndex] = min(low_of_thread[gl_LocalInvocationIndex], low_of_thread[gl_LocalInvocationIndex + step]);
      high_of_thread[gl_LocalInvocationIndex] = max(high_of_thread[gl_LocalInvocationIndex], high_of_thread[gl_LocalInvocationIndex + step]);
    }
    barrier();
  }
  if (gl_LocalInvocationIndex != 0) return;
  low = low_of_thread[0];
  high = high_of_thread[0];
  const bool known = low.x <= high.x;
  PrimitivesOut(push.primitives).at[record.primitive].mesh_center =
      known ? 0.5 * (low + high) * vec3(record.sign_x, 1, 1) : vec3(0);
  PrimitivesOut(push.primitives).at[record.primitive].mesh_radius = known ? 0.5001 * length(high - low) : 0;
}
