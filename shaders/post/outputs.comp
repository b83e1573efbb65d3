// Output planes of an image: depth, labels, normals, motion, material and position, all from one surface per
// pixel. Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_SURFACE_PLANES adds albedo, roughness, metallic, position and
// occlusion.
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
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LastPositionRef { vec3 at[]; };
#ifdef FIRE3DV_SURFACE_PLANES
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec4Out { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatRef { float at[]; };
#endif

#define kNotANumber uintBitsToFloat(0x7fc00000u)

vec2 pixels_of(GlobalsRef globals, vec4 clip) {
  precise const vec2 pixels = (clip.xy / clip.w * 0.5 + 0.5) * vec2(globals.value.width, globals.value.height);
  return pixels;
}

vec4 clip_direction(mat4 clip_from_world, vec3 direction) {
  precise const vec4 clip = clip_from_world * vec4(direction, 0);
  return clip;
}

// Corner of a triangle in the camera's last image.
vec3 last_corner(GlobalsRef globals, OutputsWanted wanted, uint vertex) {
  if (wanted.last_positions != 0ul && vertex >= wanted.first_deforming_vertex)
    return LastPositionRef(wanted.last_positions).at[vertex - wanted.first_deforming_vertex];
  return PositionRef(globals.value.positions).at[vertex];
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
    there = clip_position(wanted.last_clip_from_world, world_position(last, last_place(globals, wanted, t, b, node)));
  }
  if (there.w <= 0) return vec2(kNotANumber);  // it was behind the eye
  return pixels_of(globals, here) - pixels_of(globals, there);
}

#ifdef FIRE3DV_SURFACE_PLANES
// Relative difference of depths of one surface whose triangles meet at an angle.
const float kSameDepth = 2e-3;

// How the camera's last image showed the visible point. The plane of the point's triangle is compared at the
// centre of the last image's pixel, where that image's depth is exact.
uint occlusion_of(GlobalsRef globals, OutputsWanted wanted, ShownSurface shown) {
  if (wanted.last_world_from_node == 0ul || wanted.last_depth == 0ul || shown.id == 0) return FIRE3DV_SEEN;
  const vec2 size = vec2(globals.value.width, globals.value.height);
  const VisibleTriangle t = visible_triangle(globals, shown.id);
  const vec3 b = nearby(barycentrics_at(t, shown.position, size));
  const AffineRows last = AffineRowsRef(wanted.last_world_from_node).at[t.part.node];
  vec3 corner[3];
  for (int i = 0; i < 3; ++i) corner[i] = world_position(last, last_corner(globals, wanted, t.vertex[i]));
  const vec3 point = corner[0] * b.x + corner[1] * b.y + corner[2] * b.z;
  const vec4 clip = clip_position(wanted.last_clip_from_world, point);
  if (clip.w <= 0 || clip.z > clip.w) return FIRE3DV_OUTSIDE;
  const vec2 place = pixels_of(globals, clip);
  if (any(lessThan(place, vec2(0))) || any(greaterThanEqual(place, size))) return FIRE3DV_OUTSIDE;
  const uvec2 pixel = uvec2(place);
  float depth_m = dot(point - wanted.last_eye_world, wanted.last_look_world);
  if (wanted.orthographic == 0) {
    const vec2 ndc = (vec2(pixel) + 0.5) / size * 2 - 1;
    const vec3 ray = wanted.last_world_from_ndc_x * ndc.x + wanted.last_world_from_ndc_y * ndc.y + wanted.last_world_from_ndc_origin;
    const vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
    const float at_center = dot(normal, point - wanted.last_eye_world) / dot(normal, ray);
    // A plane seen edge-on has no depth at the centre.
    if (abs(at_center - depth_m) < 0.5 * depth_m) depth_m = at_center;
  }
  const float last_depth_m = FloatRef(wanted.last_depth).at[pixel.y * globals.value.width + pixel.x];
  return last_depth_m < depth_m * (1 - kSameDepth) ? FIRE3DV_HIDDEN : FIRE3DV_SEEN;
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
