// Flow from an earlier image to this one: for each pixel of the earlier image, where this one shows the point that
// is visible there, and whether it hides it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "post/other_image.glsl"
#include "shared/flow_types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { FlowPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FlowWantedRef { FlowWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer SurfaceReferenceRef { SurfaceReference at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PartLabelsRef { PartLabels at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec2Out { vec2 at[]; };

// Position of the point where this image shows it; NaN: behind the eye.
vec2 position_at(OtherImage image, vec4 clip) { return clip.w > 0 ? pixels_of(image.size, clip) : vec2(kNotANumber); }

bool is_hidden(GlobalsRef globals, FlowWanted wanted, uint id) {
  if (wanted.hidden == 0ul) return false;
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[(id >> 7) - 1];
  const uint node = PartLabelsRef(wanted.labels).at[instance.part].instance - 1;
  return (UintRef(wanted.hidden).at[node >> 5] & (1u << (node & 31u))) != 0;
}

void main() {
  const FlowWanted wanted = FlowWantedRef(push.wanted).value;
  GlobalsRef globals = GlobalsRef(wanted.globals);
  const uvec2 size = uvec2(globals.value.width, globals.value.height), pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, size))) return;
  const uint index = pixel.y * size.x + pixel.x;
  const OtherImage image = OtherImage(globals.value.clip_from_world, globals.value.eye_world, wanted.look_world, globals.value.world_from_ndc_x,
                                      globals.value.world_from_ndc_y, globals.value.world_from_ndc_origin, wanted.orthographic, wanted.depth, size);
  const SurfaceReference from = SurfaceReferenceRef(wanted.references).at[index];
  vec2 to;
  uint occlusion = FIRE3DV_SEEN;
  if (from.id == 0) {
    const vec2 ndc = (vec2(pixel) + 0.5) / vec2(size) * 2 - 1;
    const vec3 direction = wanted.earlier_world_from_ndc_x * ndc.x + wanted.earlier_world_from_ndc_y * ndc.y + wanted.earlier_world_from_ndc_origin;
    to = wanted.earlier_orthographic != 0 || wanted.orthographic != 0 ? from.position_px : position_at(image, clip_direction(image.clip_from_world, direction));
  } else {
    const VisibleTriangle t = visible_triangle(globals, from.id);
    PositionRef positions = PositionRef(globals.value.positions);
    const vec3 b = from.barycentrics;
    const vec3 node = positions.at[t.vertex[0]] * b.x + positions.at[t.vertex[1]] * b.y + positions.at[t.vertex[2]] * b.z;
    const vec3 point = world_position(t.world_from_node, node);
    to = position_at(image, clip_position(image.clip_from_world, point));
    occlusion = occlusion_in(image, t.world, point);
    if (is_hidden(globals, wanted, from.id)) {
      to = vec2(kNotANumber);
      occlusion = FIRE3DV_HIDDEN;
    }
  }
  Vec2Out(wanted.flow).at[index] = to - from.position_px;
  WordRef(wanted.occlusion).at[index] = occlusion;
}
