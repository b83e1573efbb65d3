// Vertices of markers, generated from one position, rotation, size and colour per element. Flat shapes (points,
// lines, axes) face the viewer and take their vertices by index; solids take one instance per element.
// FIRE3DV_LAYERS numbers the triangles.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/buffers.glsl"
#include "shared/glyph_types.h"
#include "markers/marker_solids.glsl"

layout(push_constant, scalar) uniform Push { MarkerPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec4Ref { vec4 at[]; };

#ifdef FIRE3DV_LAYERS
#include "layers/layers.glsl"
layout(location = 2) flat out uint out_number;  // of the triangle
#endif
layout(location = 0) out vec4 out_color;  // linear, display-referred, straight alpha
layout(location = 1) out vec2 out_disc;   // points: of length 1 at the edge of the disc; texts, images: texel

const vec2 kCorners[6] = vec2[6](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1));

bool has(uint flag) { return (push.flags & flag) != 0; }

vec3 position_world(uint index) { return transform_point(push.world_from_marker, PositionRef(push.positions).at[index]); }

vec4 color_of(uint index) {
  if (push.colors == 0ul) return vec4(1);
  const vec4 srgb = unpackUnorm4x8(UintRef(push.colors).at[has(FIRE3DV_MARKER_COLOR_EACH) ? index : 0]);
  const vec3 low = srgb.rgb / 12.92, high = pow((srgb.rgb + 0.055) / 1.055, vec3(2.4));
  return vec4(mix(high, low, lessThanEqual(srgb.rgb, vec3(0.04045))), srgb.a);
}

vec3 size_of(uint index) { return PositionRef(push.sizes).at[has(FIRE3DV_MARKER_SIZE_EACH) ? index : 0]; }

vec3 rotate(uint index, vec3 v) {
  if (push.rotations == 0ul) return v;
  const vec4 q = normalize(Vec4Ref(push.rotations).at[has(FIRE3DV_MARKER_ROTATION_EACH) ? index : 0]);
  return v + 2 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

// Outside of the view.
void drop() { gl_Position = vec4(2, 2, 2, 1); }

vec2 image_size(GlobalsRef globals) { return vec2(globals.value.width, globals.value.height); }

// Half the image's size in pixels for a world length of 1 at w = 1, across and down, without the part of an
// off-centre view that depends on depth.
vec2 half_pixels_per_length(GlobalsRef globals) {
  const mat4 m = transpose(globals.value.clip_from_world);
  const float along = dot(m[3].xyz, m[3].xyz);
  const vec3 x = along > 0 ? m[0].xyz - m[3].xyz * (dot(m[0].xyz, m[3].xyz) / along) : m[0].xyz;
  const vec3 y = along > 0 ? m[1].xyz - m[3].xyz * (dot(m[1].xyz, m[3].xyz) / along) : m[1].xyz;
  return 0.5 * image_size(globals) * vec2(length(x), length(y));
}

float width_px(GlobalsRef globals, float w) {
  if (!has(FIRE3DV_MARKER_WIDTH_IN_LENGTHS)) return push.width;
  return push.width * half_pixels_per_length(globals).y / w;
}

// A triangle around the disc: half the vertices of a square.
const vec2 kAroundDisc[3] = vec2[3](vec2(-1.7320508, -1), vec2(1.7320508, -1), vec2(0, 2));

void draw_point(GlobalsRef globals, uint index, vec2 corner) {
  vec4 clip = globals.value.clip_from_world * vec4(position_world(index), 1);
  if (!(clip.w > 0) || clip.z > clip.w) {
    drop();
    return;
  }
  out_disc = corner;
  clip.xy += corner * width_px(globals, clip.w) / image_size(globals) * clip.w;
  gl_Position = clip;
}

void draw_glyph(GlobalsRef globals, uint glyph, vec2 corner) {
  vec4 clip = globals.value.clip_from_world * vec4(position_world(glyph), 1);
  if (!(clip.w > 0) || clip.z > clip.w) {
    drop();
    return;
  }
  const vec4 rectangle = Vec4Ref(push.rotations).at[2 * glyph], texels = Vec4Ref(push.rotations).at[2 * glyph + 1];
  const vec2 share = 0.5 * corner + 0.5;
  out_disc = mix(texels.xy, texels.zw, share);
  const vec2 offset_px = mix(rectangle.xy, rectangle.zw, share) * width_px(globals, clip.w);
  clip.xy += vec2(offset_px.x, -offset_px.y) / (0.5 * image_size(globals)) * clip.w;
  gl_Position = clip;
}

// extend: half widths that the rectangle is longer at both ends.
void draw_line(GlobalsRef globals, vec3 from_world, vec3 to_world, vec4 from_color, vec4 to_color, vec2 corner, float extend) {
  vec4 from = globals.value.clip_from_world * vec4(from_world, 1);
  vec4 to = globals.value.clip_from_world * vec4(to_world, 1);
  // Both ends must lie beyond the near plane to be in the image.
  const float from_near = from.w - from.z, to_near = to.w - to.z;
  if (!(from_near > 0) && !(to_near > 0)) {
    drop();
    return;
  }
  const float cut = from_near / (from_near - to_near);
  if (!(from_near > 0)) {
    from = mix(from, to, cut);
    from_color = mix(from_color, to_color, cut);
  } else if (!(to_near > 0)) {
    to = mix(from, to, cut);
    to_color = mix(from_color, to_color, cut);
  }
  if (!(from.w > 0) || !(to.w > 0)) {
    drop();
    return;
  }
  const vec2 half_size = 0.5 * image_size(globals);
  const vec2 along_px = (to.xy / to.w - from.xy / from.w) * half_size;
  const float length_px = length(along_px);
  const vec2 along = length_px > 1e-6 ? along_px / length_px : vec2(1, 0);
  const bool is_end = corner.x > 0;
  vec4 clip = is_end ? to : from;
  out_color = is_end ? to_color : from_color;
  const float half_width_px = 0.5 * width_px(globals, clip.w);
  const vec2 offset_px = half_width_px * (vec2(-along.y, along.x) * corner.y + along * corner.x * extend);
  clip.xy += offset_px / half_size * clip.w;
  gl_Position = clip;
}

// Shaded by the angle to the viewer, so that the shape shows without lights.
void draw_solid(GlobalsRef globals, vec3 point_world, vec3 normal_world, vec4 color) {
  const vec4 clip = globals.value.clip_from_world * vec4(point_world, 1);
  const bool is_orthographic = globals.value.clip_from_world[0][3] == 0 && globals.value.clip_from_world[1][3] == 0 &&
                               globals.value.clip_from_world[2][3] == 0;
  const vec3 to_eye = is_orthographic ? -globals.value.world_from_ndc_origin : globals.value.eye_world - point_world;
  const float cosine = abs(dot(normalize(normal_world), normalize(to_eye)));
  out_color = vec4(color.rgb * mix(0.3, 1.0, clamp(cosine, 0, 1)), color.a);
  gl_Position = clip;
}

void draw_triangle(GlobalsRef globals, uint index) {
  const uint first = index - index % 3;
  const vec3 a = position_world(first), b = position_world(first + 1), c = position_world(first + 2);
  draw_solid(globals, index % 3 == 0 ? a : index % 3 == 1 ? b : c, cross(b - a, c - a), color_of(index));
}

void draw_arrow(GlobalsRef globals, uint arrow, uint vertex) {
  const vec3 tail = position_world(2 * arrow), tip = position_world(2 * arrow + 1);
  const float length_world = length(tip - tail);
  if (!(length_world > 0)) {
    drop();
    return;
  }
  float diameter = push.width;
  if (!has(FIRE3DV_MARKER_WIDTH_IN_LENGTHS)) {
    const vec4 middle = globals.value.clip_from_world * vec4(0.5 * (tail + tip), 1);
    diameter *= max(middle.w, 0) / half_pixels_per_length(globals).y;
  }
  const SolidVertex v = arrow_vertex(vertex, push.segments, 0.5 * diameter, length_world);
  const vec3 z = (tip - tail) / length_world;
  const vec3 x = normalize(cross(abs(z.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0), z));
  const mat3 world_from_arrow = mat3(x, cross(z, x), z);
  draw_solid(globals, tail + world_from_arrow * v.point, world_from_arrow * v.normal,
             mix(color_of(2 * arrow), color_of(2 * arrow + 1), clamp(v.point.z / length_world, 0, 1)));
}

void draw_shape(GlobalsRef globals, uint index, uint vertex) {
  const SolidVertex v = push.kind == FIRE3DV_MARKER_BOXES       ? box_vertex(vertex, size_of(index))
                        : push.kind == FIRE3DV_MARKER_CYLINDERS ? cylinder_vertex(vertex, push.segments, size_of(index))
                        : ball_vertex(vertex, push.segments, push.rings, size_of(index), push.kind == FIRE3DV_MARKER_CAPSULES);
  const vec3 point = PositionRef(push.positions).at[index] + rotate(index, v.point);
  draw_solid(globals, transform_point(push.world_from_marker, point),
             transform_normal(push.world_from_marker, rotate(index, v.normal)), color_of(index));
}

void draw_axis(GlobalsRef globals, uint index, uint axis, vec2 corner) {
  vec3 along = vec3(0), color = vec3(0);
  along[axis] = size_of(index)[axis];
  color[axis] = 1;
  const vec3 end = PositionRef(push.positions).at[index] + rotate(index, along);
  draw_line(globals, position_world(index), transform_point(push.world_from_marker, end), vec4(color, 1), vec4(color, 1), corner, 0);
}

// Both sides; left at -x, the top at +y.
void draw_image(GlobalsRef globals, uint index, vec2 corner) {
  const vec3 point = PositionRef(push.positions).at[index] + rotate(index, vec3(0.5 * size_of(index).xy * corner, 0));
  out_disc = vec2(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y) * vec2(push.segments, push.rings);
  gl_Position = globals.value.clip_from_world * vec4(transform_point(push.world_from_marker, point), 1);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  out_color = vec4(1);
  out_disc = vec2(0);
#ifdef FIRE3DV_LAYERS
  out_number = push.first_number + gl_InstanceIndex * push.triangles + gl_VertexIndex / 3;
  const bool has_work = LayerWorkRef(LayerTargetRef(push.target).value.work).at[push.pass].draw_count != 0;
#else
  const bool has_work = true;
#endif
  if (is_ended() || !has_work) {
    drop();
    return;
  }
  const uint vertex = gl_VertexIndex, element = vertex / 6;
  const vec2 corner = kCorners[vertex % 6];
  switch (push.kind) {
    case FIRE3DV_MARKER_POINTS:
      draw_point(globals, vertex / 3, kAroundDisc[vertex % 3]);
      out_color = color_of(vertex / 3);
      break;
    case FIRE3DV_MARKER_LINES:
      draw_line(globals, position_world(2 * element), position_world(2 * element + 1), color_of(2 * element), color_of(2 * element + 1), corner, 0);
      break;
    case FIRE3DV_MARKER_LINE_STRIP:
      draw_line(globals, position_world(element), position_world(element + 1), color_of(element), color_of(element + 1), corner, 1);
      break;
    case FIRE3DV_MARKER_AXES:
      draw_axis(globals, element / 3, element % 3, corner);
      break;
    case FIRE3DV_MARKER_TRIANGLES:
      draw_triangle(globals, vertex);
      break;
    case FIRE3DV_MARKER_TEXTS:
      draw_glyph(globals, element, corner);
      out_color = color_of(element);
      break;
    case FIRE3DV_MARKER_IMAGES:
      draw_image(globals, element, corner);
      break;
    case FIRE3DV_MARKER_ARROWS:
      draw_arrow(globals, gl_InstanceIndex, vertex);
      break;
    default:
      draw_shape(globals, gl_InstanceIndex, vertex);
  }
  // Numbers of a stream may be huge.
  if (any(isinf(gl_Position)) || any(isnan(gl_Position))) drop();
}
