// Deformation of vertices, one per thread: morph targets first, then skinning. Skinned vertices are written
// in world space, since a skinned mesh ignores its own node's transform.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/joint_matrix.glsl"
#include "common/vertices.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { DeformPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InfluenceRef { InfluenceRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DeltaRef { MorphDeltaRecord at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatRef { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PositionsRef { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer FramesRef { FrameRecord at[]; };

AffineRows blended_matrix(DeformRecord record, uint source) {
  if (record.first_influence == FIRE3DV_NO_INDEX) return AffineRowsRef(push.world_from_node).at[record.node];
  AffineRows sum = AffineRows(vec4(0), vec4(0), vec4(0));
  for (uint set = 0; set < record.influence_sets; ++set) {
    const InfluenceRecord influence =
        InfluenceRef(push.influences).at[record.first_influence + source * record.influence_sets + set];
    const uint joints[4] = {influence.joints_low & 0xffffu, influence.joints_low >> 16, influence.joints_high & 0xffffu,
                            influence.joints_high >> 16};
    for (uint i = 0; i < 4; ++i) {
      const float weight = influence.weights[i];
      if (weight == 0) continue;
      const AffineRows m = world_from_mesh(push, record, joints[i]);
      sum.row0 += weight * m.row0;
      sum.row1 += weight * m.row1;
      sum.row2 += weight * m.row2;
    }
  }
  return sum;
}

vec3 unit_or(vec3 v, vec3 otherwise) {
  const float size2 = dot(v, v);
  return size2 > 0 && !isinf(size2) ? v * inversesqrt(size2) : otherwise;
}

// Projects the tangent into the plane of the normal.
vec3 perpendicular(vec3 tangent, vec3 normal) {
  const vec3 any_other = abs(normal.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0);
  const vec3 fallback = normalize(any_other - normal * dot(normal, any_other));
  const vec3 flat_tangent = tangent - normal * dot(normal, tangent);
  return dot(flat_tangent, flat_tangent) > 1e-12 * dot(tangent, tangent) ? unit_or(flat_tangent, fallback) : fallback;
}

void main() {
  const uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (group >= push.group_count) return;
  const DeformGroup work = DeformGroupRef(push.groups).at[group];
  const DeformRecord record = DeformRecordRef(push.records).at[work.record];
  const uint vertex = work.first_vertex + gl_LocalInvocationIndex;
  if (vertex >= record.vertex_count) return;
  const uint source = UintRef(push.sources).at[record.first_source + vertex];

  vec3 position = PositionsRef(push.positions).at[record.rest_vertex + vertex];
  const FrameRecord rest = FramesRef(push.frames).at[record.rest_vertex + vertex];
  vec3 normal = normal_of(rest);
  const vec4 rest_tangent = tangent_of(rest, tangent_xy_of(UintRef(push.tangents), record.rest_vertex + vertex));
  vec3 tangent = rest_tangent.xyz;
  const vec3 rest_normal = unit_or(normal, vec3(0, 0, 1));
  for (uint target = 0; target < record.target_count; ++target) {
    const float weight = FloatRef(push.weights).at[record.first_weight + target];
    if (weight == 0) continue;
    const MorphDeltaRecord delta =
        DeltaRef(push.deltas).at[record.first_delta + target * record.delta_stride + source];
    position += weight * delta.position;
    normal += weight * delta.normal;
    tangent += weight * delta.tangent;
  }
  normal = unit_or(normal, rest_normal);
  if (record.skinned != 0) {
    const AffineRows world_from_rest = blended_matrix(record, source);
    position = transform_point(world_from_rest, position);
    normal = unit_or(transform_normal(world_from_rest, normal), normal);
    tangent = transform_direction(world_from_rest, tangent);
    position.x *= record.sign_x;
    normal.x *= record.sign_x;
    tangent.x *= record.sign_x;
  }
  // A NaN vertex would deactivate its triangle in the acceleration structure; an update must not change the
  // set of active triangles.
  if (any(isnan(position)) || any(isinf(position))) position = vec3(0);
  PositionsRef(push.positions).at[record.posed_vertex + vertex] = position;
  tangent = perpendicular(tangent, normal);
  FramesRef(push.frames).at[record.posed_vertex + vertex] = packed_frame(normal, vec4(tangent, rest_tangent.w));
  if (push.tangents != 0) UintsRef(push.tangents).at[record.posed_vertex + vertex] = packed_halves(tangent.x, tangent.y);
}
