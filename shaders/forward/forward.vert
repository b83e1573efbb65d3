// Vertex pulling and transform to world and clip space. Variant: FIRE3DV_LAYERS numbers the primitives.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/vertices.glsl"

#ifdef FIRE3DV_LAYERS
layout(push_constant, scalar) uniform Push { LayerPush push; };
layout(location = 10) flat out uint out_first_number;
layout(location = 11) flat out uint out_instance;
layout(location = 12) flat out float out_scale;  // mean stretch of the node
uint draw_index() { return gl_InstanceIndex % push.draw_count; }
#else
layout(push_constant, scalar) uniform Push { ForwardPush push; };
uint draw_index() { return gl_InstanceIndex; }
#endif
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

invariant gl_Position;  // the depth pass and the colour pass need identical bits
layout(location = 0) out vec3 out_position_world;
layout(location = 1) out vec3 out_normal_world;
layout(location = 2) out vec4 out_tangent_world;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;
layout(location = 5) flat out uint out_material;
layout(location = 6) out vec3 out_position_center;
layout(location = 7) out vec4 out_uv_center;
layout(location = 8) flat out uint out_part_flags;
layout(location = 9) out vec4 out_tangent_plane;  // w: distance from the eye, scaled by the normal's length

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const DrawRecord draw = DrawRef(globals.value.draws).at[draw_index()];
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[draw.node];
  const vec3 position_node = PositionRef(globals.value.positions).at[gl_VertexIndex];
  const FrameRecord frame = FrameRef(globals.value.frames).at[gl_VertexIndex];
  const vec4 tangent = tangent_of(frame, tangent_xy_of(UintRef(globals.value.tangents), gl_VertexIndex));
  ExtrasRef extras = ExtrasRef(globals.value.extras);

  out_position_world = transform_point(world_from_node, position_node);
  out_position_center = out_position_world;
  out_normal_world = transform_normal(world_from_node, normal_of(frame));
  out_tangent_plane = vec4(out_normal_world, dot(out_position_world - globals.value.eye_world, out_normal_world));
  out_tangent_world = vec4(transform_direction(world_from_node, tangent.xyz), tangent.w);
  out_uv = vec4(UvRef(globals.value.uvs).at[gl_VertexIndex], uv1_of(extras, gl_VertexIndex));
  out_uv_center = out_uv;
  out_color = color_of(extras, gl_VertexIndex);
  out_material = PrimitiveRef(globals.value.primitives).at[draw.primitive].material;
  out_part_flags = PartRef(globals.value.parts).at[draw.part].flags;
#ifdef FIRE3DV_LAYERS
  out_first_number = draw.first_number + gl_InstanceIndex / push.draw_count * push.piece_triangles;
  out_instance = draw.part;
  out_scale = pow(abs(dot(world_from_node.row0.xyz, cross(world_from_node.row1.xyz, world_from_node.row2.xyz))), 1.0 / 3);
#endif
  gl_PointSize = 1;
  gl_Position = globals.value.clip_from_world * vec4(out_position_world, 1);
  if (is_ended()) gl_Position = vec4(2, 2, 2, 1);  // outside of the view
}
