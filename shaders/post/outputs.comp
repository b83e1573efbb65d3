// Output planes of an image: depth, labels, normals, motion, material and position, all from one surface per
// pixel. Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_SURFACE_PLANES adds albedo, roughness, metallic, position and
// occlusion.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "common/push_of_group.glsl"
#include "post/other_image.glsl"
#include "shading/shown_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { OutputsPush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(OutputsPush, OutputsPushRef, globals, gl_WorkGroupID.z)
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer OutputsWantedRef { OutputsWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PartLabelsRef { PartLabels at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer FloatOut { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec2Out { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer HalfsOut { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LastPositionRef { vec3 at[]; };
#ifdef FIRE3DV_SURFACE_PLANES
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec4Out { vec4 at[]; };
#endif

// Corner of a triangle in the camera's last image.
vec3 last_corner(GlobalsRef globals, OutputsWanted wanted, uint vertex) {
  if (wanted.last_positions != 0ul && vertex >= wanted.first_deforming_vertex)
    return LastPositionRef(wanted.last_positions).at[vertex - wanted.first_deforming_vertex];
  return PositionRef(globals.value.positions).at[vertex];
}

// Whether the camera's last image had the node of a triangle hidden.
bool was_hidden(GlobalsRef globals, OutputsWanted wanted, VisibleTriangle t, AffineRows last) {
  if (floatBitsToUint(last.row0.x) == FIRE3DV_NO_PLACE) return true;
  const bool is_deformed = (t.part.flags & FIRE3DV_PART_DEFORMED) != 0;
  return is_deformed && floatBitsToUint(last_corner(globals, wanted, t.vertex[0]).x) == FIRE3DV_NO_PLACE;
}

// Place in node space that the point of a triangle had in the camera's last image. here: its place now.
vec3 last_place(GlobalsRef globals, OutputsWanted wanted, VisibleTriangle t, vec3 b, vec3 here) {
  if ((t.part.flags & FIRE3DV_PART_DEFORMED) == 0) return here;
  bool is_same = true;
  vec3 sum = vec3(0);
  for (int i = 0; i < 3; ++i) {
    const vec3 corner = last_corner(globals, wanted, t.vertex[i]);
    is_same = is_same && corner == PositionRef(globals.value.positions).at[t.vertex[i]];
    sum += corner * b[i];
  }
  return is_same ? here : sum;
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
    if (was_hidden(globals, wanted, t, last)) return vec2(kNotANumber);
    there = clip_position(wanted.last_clip_from_world, world_position(last, last_place(globals, wanted, t, b, node)));
  }
  if (there.w <= 0) return vec2(kNotANumber);  // it was behind the eye
  const uvec2 size = uvec2(globals.value.width, globals.value.height);
  return pixels_of(size, here) - pixels_of(size, there);
}

#ifdef FIRE3DV_SURFACE_PLANES
// How the camera's last image showed the visible point.
uint occlusion_of(GlobalsRef globals, OutputsWanted wanted, ShownSurface shown) {
  if (wanted.last_world_from_node == 0ul || wanted.last_depth == 0ul || shown.id == 0) return FIRE3DV_SEEN;
  const uvec2 size = uvec2(globals.value.width, globals.value.height);
  const VisibleTriangle t = visible_triangle(globals, shown.id);
  const vec3 b = nearby(barycentrics_at(t, shown.position, vec2(size)));
  const AffineRows last = AffineRowsRef(wanted.last_world_from_node).at[t.part.node];
  if (was_hidden(globals, wanted, t, last)) return FIRE3DV_HIDDEN;
  vec3 corner[3];
  for (int i = 0; i < 3; ++i) corner[i] = world_position(last, last_corner(globals, wanted, t.vertex[i]));
  const OtherImage image = OtherImage(wanted.last_clip_from_world, wanted.last_eye_world, wanted.last_look_world, wanted.last_world_from_ndc_x,
                                      wanted.last_world_from_ndc_y, wanted.last_world_from_ndc_origin, wanted.last_orthographic, wanted.last_depth, size);
  return occlusion_in(image, corner, corner[0] * b.x + corner[1] * b.y + corner[2] * b.z);
}

// Albedo, roughness, metallic and position; all 0 for the background.
void write_surface(GlobalsRef globals, OutputsWanted wanted, ShownSurface shown, uint index) {
  vec4 albedo = vec4(0), position = vec4(0);
  float roughness = 0, metallic = 0;
  if (shown.id != 0) {
    const SurfacePoint point = surface_point(globals, visible_triangle(globals, shown.id), shown.position);
    const MaterialRecord material = MaterialRef(globals.value.materials).at[point.material];
    const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
    albedo = vec4((material.base_color * point.color * sample_or(material.base_color_texture, uv, dx, dy, vec4(1))).rgb, 1);
    const vec4 texel = sample_or(material.metallic_roughness_texture, uv, dx, dy, vec4(1));
    roughness = clamp(material.roughness * texel.g, 0, 1);
    metallic = clamp(material.metallic * texel.b, 0, 1);
    position = vec4(point.position_world, 1);
  }
  if (wanted.albedo != 0ul) HalfsOut(wanted.albedo).at[index] = pack_halves(albedo.rgb, albedo.a);
  if (wanted.roughness != 0ul) FloatOut(wanted.roughness).at[index] = roughness;
  if (wanted.metallic != 0ul) FloatOut(wanted.metallic).at[index] = metallic;
  if (wanted.position != 0ul) Vec4Out(wanted.position).at[index] = position;
}
#endif

void main() {
  push = push_of_group();
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
#ifdef FIRE3DV_SURFACE_PLANES
  if ((wanted.albedo | wanted.roughness | wanted.metallic | wanted.position) != 0ul) write_surface(globals, wanted, shown, index);
  if (wanted.occlusion != 0ul) WordRef(wanted.occlusion).at[index] = occlusion_of(globals, wanted, shown);
#endif
}
