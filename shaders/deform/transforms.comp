// World transforms of all nodes from stream poses, with derived light and node data and TLAS instance
// transforms.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "common/push_of_group.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { TransformsPush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(TransformsPush, TransformsPushRef, sources, gl_WorkGroupID.y)

void place_light(uint index, AffineRows world_from_light) {
  const LightRecord record = LightRef(push.lights).at[index];
  LightPose pose;
  pose.color = record.color;
  pose.range_m = record.range_m;
  pose.position_world = vec3(world_from_light.row0.w, world_from_light.row1.w, world_from_light.row2.w);
  pose.type = record.type;
  pose.light_direction_world = normalize(-vec3(world_from_light.row0.z, world_from_light.row1.z, world_from_light.row2.z));
  pose.cone_scale = record.cone_scale;
  pose.cone_offset = record.cone_offset;
  pose.radius_m = record.radius_m;
  pose.angular_radius_rad = record.angular_radius_rad;
  pose.sine = sin(record.angular_radius_rad);
  LightPoseRef(push.light_poses).at[index] = pose;
}

void main() {
  push = push_of_group();
  const uint node = gl_GlobalInvocationID.x;
  if (node >= push.node_count) return;

  const NodeSource source = NodeSourceRef(push.sources).at[node];
  AffineRows world_from_node = source.body_from_node;
  if (source.stream != FIRE3DV_NO_INDEX) {
    const StreamSource stream = StreamSourceRef(push.streams).at[source.stream];
    const AffineRows stream_from_body = AffineRowsRef(stream.poses).at[source.pose_index];
    world_from_node = multiply(multiply(stream.world_from_stream, stream_from_body), world_from_node);
  }
  AffineRowsRef(push.world_from_node).at[node] = world_from_node;
  UintsRef(push.node_facts).at[node] = (is_mirroring(world_from_node) ? FIRE3DV_NODE_MIRRORED : 0) |
                                       (scales_evenly(world_from_node) ? FIRE3DV_NODE_EVEN : 0);
  const uint light = UintRef(push.light_of_node).at[node];
  if (light != FIRE3DV_NO_INDEX) place_light(light, world_from_node);

  if (push.instances == 0ul) return;
  const uint instance = UintRef(push.instance_of_node).at[node];
  if (instance == FIRE3DV_NO_INDEX) return;
  // The first 48 of an instance's 64 bytes hold the transform, then 24 bits of index and 8 of mask. Singular
  // transforms are invalid in the structure, so their instances get mask 0 and cast no shadow.
  const vec3 r0 = world_from_node.row0.xyz, r1 = world_from_node.row1.xyz, r2 = world_from_node.row2.xyz;
  const float volume = abs(dot(r0, cross(r1, r2)));
  const bool solid = volume > 0 && !isinf(volume) && !isnan(volume);
  if (!solid) {
    world_from_node.row0 = vec4(1, 0, 0, 0);
    world_from_node.row1 = vec4(0, 1, 0, 0);
    world_from_node.row2 = vec4(0, 0, 1, 0);
  }
  const uint64_t record = push.instances + uint64_t(instance) * 64ul;
  AffineRowsRef(record).at[0] = world_from_node;
  WordRef(record + 48ul).at[0] = (node & 0xffffffu) | (solid ? 0xff000000u : 0u);
}
