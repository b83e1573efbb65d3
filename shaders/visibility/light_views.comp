// Views of shadow maps, one workgroup each, fitted to the current shadow casters. Further workgroups compute
// per-part and per-caster data of the shadow test.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/push_of_group.glsl"
#include "visibility/planar_casters.glsl"
#include "visibility/level_choice.glsl"

layout(local_size_x = FIRE3DV_LIGHT_VIEW_THREADS) in;
layout(push_constant, scalar) uniform Push { LightViewsPush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(LightViewsPush, LightViewsPushRef, globals, gl_WorkGroupID.y)

shared vec3 low_of_thread[FIRE3DV_LIGHT_VIEW_THREADS];
shared vec3 high_of_thread[FIRE3DV_LIGHT_VIEW_THREADS];

// Reads the static records, since other workgroups are writing the SheetPlaces.
bool is_listed_sheet(GlobalsRef globals, uint part) {
  for (uint i = 0; i < globals.value.planar_caster_count; ++i) {
    if (PlanarCasterRef(push.planar_casters).at[i].part == part) return true;
  }
  return false;
}

void look_at_parts(GlobalsRef globals, uint group) {
  const uint index = group * FIRE3DV_LIGHT_VIEW_THREADS + gl_LocalInvocationIndex;
  if (index < globals.value.part_count) {
    const PartRecord part = PartRef(globals.value.parts).at[index];
    bool by_back_faces = can_cast_by_back_faces(globals, part);
    // All cameras' images use the same maps.
    for (uint i = 1; i < push.camera_count && by_back_faces; ++i) {
      by_back_faces = can_cast_by_back_faces(GlobalsRef(AddressRef(push.cameras).at[i]), part);
    }
    UintsRef(globals.value.backface_casters).at[index] = by_back_faces ? 1 : 0;
  }
  if (index < globals.value.planar_caster_count) {
    PlanarCasterPlaneRef(globals.value.planar_casters).at[index] = planar_caster_plane(globals, PlanarCasterRef(push.planar_casters).at[index]);
  }
}

// Box around all casters of a map, in the light's axes.
void bound_casters(GlobalsRef globals, mat3 axes, out vec3 low, out vec3 high) {
  low = vec3(1e30);
  high = vec3(-1e30);
  for (uint i = gl_LocalInvocationIndex; i < globals.value.part_count; i += FIRE3DV_LIGHT_VIEW_THREADS) {
    const PartRecord part = PartRef(globals.value.parts).at[i];
    if ((part.flags & FIRE3DV_PART_NO_SHADOW) != 0 || is_listed_sheet(globals, i)) continue;
    const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
    const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[part.primitive];
    const vec3 center = transform_point(world_from_node, primitive.mesh_center) * axes;
    const float radius = primitive.mesh_radius * largest_stretch(world_from_node);
    if (any(isnan(center)) || any(isinf(center)) || isnan(radius) || isinf(radius)) continue;
    low = min(low, center - radius);
    high = max(high, center + radius);
  }
  low_of_thread[gl_LocalInvocationIndex] = low;
  high_of_thread[gl_LocalInvocationIndex] = high;
  barrier();
  for (uint step = FIRE3DV_LIGHT_VIEW_THREADS / 2; step > 0; step /= 2) {
    if (gl_LocalInvocationIndex < step) {
      low_of_thread[gl_LocalInvocationIndex] = min(low_of_thread[gl_LocalInvocationIndex], low_of_thread[gl_LocalInvocationIndex + step]);
      high_of_thread[gl_LocalInvocationIndex] = max(high_of_thread[gl_LocalInvocationIndex], high_of_thread[gl_LocalInvocationIndex + step]);
    }
    barrier();
  }
  low = low_of_thread[0];
  high = high_of_thread[0];
  if (low.x > high.x) {
    low = vec3(-1);
    high = vec3(1);
  }
}

vec3 unit_or(vec3 v, vec3 otherwise) {
  const float size2 = dot(v, v);
  return size2 > 0 && !isinf(size2) ? v * inversesqrt(size2) : otherwise;
}

// Right, up and backwards.
mat3 light_axes(AffineRows world_from_light) {
  const vec3 back = unit_or(vec3(world_from_light.row0.z, world_from_light.row1.z, world_from_light.row2.z), vec3(0, 0, 1));
  const vec3 helper = abs(back.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0);
  const vec3 right = normalize(cross(helper, back));
  return mat3(right, cross(back, right), back);
}

// Of a light without a node: the sun of an environment, or a lamp beside the lens. Right and up are open.
AffineRows placed_as(LightPose pose) {
  AffineRows world_from_light;
  world_from_light.row0 = vec4(0, 0, -pose.light_direction_world.x, pose.position_world.x);
  world_from_light.row1 = vec4(0, 0, -pose.light_direction_world.y, pose.position_world.y);
  world_from_light.row2 = vec4(0, 0, -pose.light_direction_world.z, pose.position_world.z);
  return world_from_light;
}

mat3 cube_side_axes(uint side) {
  const vec3 forward = side == 0 ? vec3(1, 0, 0) : side == 1 ? vec3(-1, 0, 0) : side == 2 ? vec3(0, 1, 0)
                     : side == 3 ? vec3(0, -1, 0) : side == 4 ? vec3(0, 0, 1) : vec3(0, 0, -1);
  const vec3 helper = side == 2 || side == 3 ? vec3(0, 0, 1) : vec3(0, 1, 0);
  const vec3 right = normalize(cross(forward, helper));
  return mat3(right, cross(right, forward), -forward);
}

vec4 inward(vec4 plane) {
  const float size = length(plane.xyz);
  return size > 0 ? plane / size : vec4(0, 0, 0, 1);
}

void main() {
  push = push_of_group();
  GlobalsRef globals = GlobalsRef(push.globals);
  if (gl_WorkGroupID.x >= push.view_count) {
    look_at_parts(globals, gl_WorkGroupID.x - push.view_count);
    return;
  }
  const LightViewRequest wanted = LightViewRequestRef(push.wanted).at[gl_WorkGroupID.x];
  const LightRecord light = LightRef(globals.value.lights).at[wanted.light];
  AffineRows world_from_light;
  if (light.node == FIRE3DV_NO_INDEX) {
    world_from_light = placed_as(LightPoseRef(globals.value.light_poses).at[wanted.light]);
  } else {
    world_from_light = AffineRowsRef(globals.value.world_from_node).at[light.node];
  }
  const bool orthographic = light.type == FIRE3DV_LIGHT_DIRECTIONAL;
  const mat3 axes = wanted.side == FIRE3DV_NO_INDEX ? light_axes(world_from_light) : cube_side_axes(wanted.side);
  vec3 low, high;
  bound_casters(globals, axes, low, high);
  if (gl_LocalInvocationIndex != 0) return;

  const vec3 position = vec3(world_from_light.row0.w, world_from_light.row1.w, world_from_light.row2.w);
  RasterView view;
  vec4 x, y, z, w;
  if (orthographic) {
    // A margin keeps the box larger than its content and never empty.
    const vec3 box_center = 0.5 * (low + high);
    const vec3 half_size = 0.505 * (high - low) + 1e-5 * (1 + length(box_center));
    x = vec4(axes[0], -box_center.x) / half_size.x;
    y = -vec4(axes[1], -box_center.y) / half_size.y;
    // 1 at the near side, 0 at the far side.
    z = vec4(axes[2], -(box_center.z - half_size.z)) / (2 * half_size.z);
    w = vec4(0, 0, 0, 1);
    view.eye_world = vec4(-axes[2], 0);
    view.depth_m = 2 * half_size.z;
    view.texel_m = 2 * max(half_size.x, half_size.y) / wanted.size;
  } else {
    // Cube faces overlap by a texel or more, so that seams have no gaps.
    const float tangent = wanted.side == FIRE3DV_NO_INDEX ? tan(wanted.half_angle_rad) * 1.02 : 1.02;
    const float near_m = 1e-5 * max(length(high - low), 1e-6);
    x = vec4(axes[0], -dot(axes[0], position)) / tangent;
    y = -vec4(axes[1], -dot(axes[1], position)) / tangent;
    w = -vec4(axes[2], -dot(axes[2], position));
    z = vec4(0, 0, 0, near_m);
    view.eye_world = vec4(position, 1);
    view.depth_m = near_m;
    view.texel_m = 2 * tangent / wanted.size;
  }
  view.clip_from_world = transpose(mat4(x, y, z, w));
  view.planes_world[0] = inward(w + x);
  view.planes_world[1] = inward(w - x);
  view.planes_world[2] = inward(w + y);
  view.planes_world[3] = inward(w - y);
  view.planes_world[4] = inward(w - z);
  view.planes_world[5] = inward(z);
  view.width = wanted.size;
  view.height = wanted.size;
  view.first_texel = push.first_texel + wanted.first_texel;
  view.first_tile = view.first_texel >> (2 * FIRE3DV_TILE_SHIFT);
  const float texels_per_m = 0.5 * wanted.size * max(length(x.xyz), length(y.xyz));
  view.level_scale = push.levels_of_detail != 0 ? texels_per_m / kLevelTexels : 0;
  RasterViewOut(push.views).at[gl_WorkGroupID.x] = view;
}
