// Output planes of an image: depth, labels, normals and motion, all from one surface per pixel. Variants:
// FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "shading/shown_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { OutputsPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer OutputsWantedRef { OutputsWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PartLabelsRef { PartLabels at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer FloatOut { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec2Out { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer HalfsOut { uvec2 at[]; };

#define kNotANumber uintBitsToFloat(0x7fc00000u)

vec2 pixels_of(GlobalsRef globals, vec4 clip) {
  precise const vec2 pixels = (clip.xy / clip.w * 0.5 + 0.5) * vec2(globals.value.width, globals.value.height);
  return pixels;
}

vec4 clip_direction(mat4 clip_from_world, vec3 direction) {
  precise const vec4 clip = clip_from_world * vec4(direction, 0);
  return clip;
}

// Motion in the image since the camera's last one, in pixels. Both positions use the same arithmetic, so that
// static surfaces yield exactly zero.
vec2 motion_of(GlobalsRef globals, OutputsWanted wanted, ShownSurface shown) {
  if (wanted.last_world_from_node == 0ul) return vec2(0);
  vec4 here, there;
  if (shown.id == 0) {
    if (wanted.orthographic != 0) return vec2(0);
    const vec3 direction = ray_through(globals, shown.position);
    here = clip_direction(globals.value.clip_from_world, direction);
    there = clip_direction(wanted.last_clip_from_world, direction);
  } else {
    const VisibleTriangle t = visible_triangle(globals, shown.id);
    const vec3 b = nearby(barycentrics_at(t, shown.position, vec2(globals.value.width, globals.value.height)));
    PositionRef positions = PositionRef(globals.value.positions);
    const vec3 node = positions.at[t.vertex[0]] * b.x + positions.at[t.vertex[1]] * b.y + positions.at[t.vertex[2]] * b.z;
    here = clip_position(globals.value.clip_from_world, world_position(t.world_from_node, node));
    const AffineRows last = AffineRowsRef(wanted.last_world_from_node).at[t.part.node];
    there = clip_position(wanted.last_clip_from_world, world_position(last, node));
  }
  if (there.w <= 0) return vec2(kNotANumber);  // it was behind the eye
  return pixels_of(globals, here) - pixels_of(globals, there);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  const uint index = pixel.y * globals.value.width + pixel.x;
  const OutputsWanted wanted = OutputsWantedRef(push.wanted).value;
  const ShownSurface shown = shown_in(globals, Eye(push.visibility, wanted.look_world, wanted.orthographic), pixel);
  if (wanted.depth != 0ul) FloatOut(wanted.depth).at[index] = shown.depth_m;
  if ((wanted.instance | wanted.semantic) != 0ul) {
    PartLabels labels = PartLabels(0, 0);
    if (shown.id != 0) labels = PartLabelsRef(wanted.labels).at[part_of_id(globals, shown.id)];
    if (wanted.instance != 0ul) WordRef(wanted.instance).at[index] = labels.instance;
    if (wanted.semantic != 0ul) WordRef(wanted.semantic).at[index] = labels.semantic;
  }
  if (wanted.normal != 0ul) {
    const vec3 normal = shown.id != 0 ? normal_of(globals, shown) : vec3(0);
    HalfsOut(wanted.normal).at[index] = pack_halves(normal.xyz, 0);
  }
  if (wanted.motion != 0ul) Vec2Out(wanted.motion).at[index] = motion_of(globals, wanted, shown);
}
