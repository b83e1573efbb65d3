// world_from_node of every node, from the poses as they came over the wire, and the transforms of the TLAS instances.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { TransformsPush push; };

void main() {
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

  if (push.instances == 0ul) return;
  const uint instance = UintRef(push.instance_of_node).at[node];
  if (instance == FIRE3DV_NO_INDEX) return;
  // The transform is the first 48 bytes of the 64 of an instance.
  AffineRowsRef(push.instances + uint64_t(instance) * 64ul).at[0] = world_from_node;
}
