// Cluster culling of one view into lists. The order of a list does not affect the image, since ids follow
// from the scene.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "visibility/culling.glsl"
#include "visibility/level_choice.glsl"
#ifdef FIRE3DV_LIGHTS
#include "visibility/planar_casters.glsl"
#else
#include "visibility/screen_bounds.glsl"
#endif

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { RasterPush push; };

// Dispatch of all views together, in the record behind theirs: as many groups as the longest list needs.
void extend_common(ViewWorkRef work, bool masked, uint count, bool one_row) {
  const uint all = gl_NumWorkGroups.z, groups_x = one_row ? count : min(count, 65535u), groups_y = (count - 1) / 65535 + 1;
  if (masked) {
    atomicMax(work.at[all].masked.groups_x, groups_x);
    if (!one_row) atomicMax(work.at[all].masked.groups_y, groups_y);
  } else {
    atomicMax(work.at[all].solid.groups_x, groups_x);
    if (!one_row) atomicMax(work.at[all].solid.groups_y, groups_y);
  }
}

void append(bool wanted, uint view, bool masked, uint entry) {
  RasterSet set = RasterSetRef(push.set).value;
  const uvec4 ballot = subgroupBallot(wanted);
  const uint count = subgroupBallotBitCount(ballot);
  if (count == 0) return;
  uint base = 0;
  ViewWorkRef work = ViewWorkRef(set.work);
  if (subgroupElect()) {
    // One counter for the whole view: a second atomic would dominate the culling time.
    if (set.one_row != 0) {
      base = masked ? atomicAdd(work.at[view].masked.groups_x, count) : atomicAdd(work.at[view].solid.groups_x, count);
    } else if (masked) {
      base = atomicAdd(work.at[view].masked.count, count);
      atomicMax(work.at[view].masked.groups_x, min(base + count, 65535u));
      atomicMax(work.at[view].masked.groups_y, (base + count - 1) / 65535 + 1);
    } else {
      base = atomicAdd(work.at[view].solid.count, count);
      atomicMax(work.at[view].solid.groups_x, min(base + count, 65535u));
      atomicMax(work.at[view].solid.groups_y, (base + count - 1) / 65535 + 1);
    }
  }
  if (kSeveralWorlds && subgroupElect()) extend_common(work, masked, base + count, set.one_row != 0);
  base = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot);
  const uint slot = masked ? set.instance_count - 1 - base : base;
  if (wanted) UintsRef(set.lists).at[view * set.instance_count + slot] = entry;
}

#ifndef FIRE3DV_LIGHTS
// True if this round of two-pass occlusion culling draws a cluster in view. Clusters not hidden now are drawn
// early in the next frame. Newly visible clusters are therefore never missing.
bool is_this_rounds(RasterSet set, uint index, bool in_view, ScreenBounds bounds) {
  UintsRef was_visible = UintsRef(set.was_visible);
  const bool early = was_visible.at[index] != 0;
  if (set.round == FIRE3DV_ROUND_EARLY) return in_view && early;
  const RasterView view = RasterViewRef(set.views).at[0];
  const bool seen = in_view && !(bounds.known && is_hidden(bounds, set.hiz, ivec2(view.width, view.height)));
  was_visible.at[index] = seen ? 1 : 0;
  return seen && !early;
}
#endif

layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer QuadsRef { uvec4 at[]; };

// Clears the camera's next target. This overlaps with culling, which mostly waits for reads.
void clear_target(RasterSet set, uint group) {
  for (uint i = 0; i < FIRE3DV_CLEAR_QUADS; ++i) {
    const uint quad = (group * FIRE3DV_CLEAR_QUADS + i) * 64 + gl_LocalInvocationIndex;
    if (quad < set.clear_quads) QuadsRef(set.target).at[quad] = uvec4(0);
  }
}

void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  const uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (group >= set.cull_groups) {
    clear_target(set, (group - set.cull_groups) * gl_NumWorkGroups.z + gl_WorkGroupID.z);
    return;
  }
  const uint index = group * 64 + gl_LocalInvocationIndex;
  const uint view_index = gl_GlobalInvocationID.z;
  if (kSeveralWorlds) globals = globals_of_view(set, view_index);
  bool wanted = index < set.instance_count;
  bool masked = false, one_side = false;
  if (wanted) {
    const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[index];
    const PartRecord part = PartRef(globals.value.parts).at[instance.part];
    masked = (part.flags & FIRE3DV_PART_MASK) != 0;
#ifdef FIRE3DV_LIGHTS
    wanted = (part.flags & FIRE3DV_PART_NO_SHADOW) == 0 && !is_planar_caster(globals, instance.part);
    const bool include_attributes = masked;  // a texture cuts holes
#else
    wanted = (part.flags & FIRE3DV_PART_FORWARD_ONLY) == 0;
#endif
    const ClusterRecord cluster = ClusterRef(globals.value.clusters).at[instance.cluster];
    const RasterView view = RasterViewRef(set.views).at[view_index];
#ifndef FIRE3DV_LIGHTS
    const bool include_attributes = view.surface_only == 0 || masked;
#endif
    const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
    wanted = wanted && is_chosen_level(globals, view, cluster, world_from_node, include_attributes);
    one_side = wanted && draws_one_side(globals, instance.part, part);
    if (set.cull != 0) {
      const vec4 sphere = sphere_of_cluster(globals, part, cluster, world_from_node);
      wanted = wanted && can_be_seen(globals, view, instance.part, part, cluster, world_from_node, sphere);
#ifndef FIRE3DV_LIGHTS
      ScreenBounds bounds;
      bounds.known = false;
      if (wanted && sphere.w > 0) bounds = screen_bounds(view, sphere.xyz, sphere.w);
      if (bounds.known && misses_samples(bounds)) wanted = false;
      if (set.round != FIRE3DV_ROUND_ONLY) wanted = is_this_rounds(set, index, wanted, bounds);
#endif
    }
  }
  const uint entry = one_side ? index | FIRE3DV_LISTED_ONE_SIDE : index;
  append(wanted && !masked, view_index, false, entry);
  append(wanted && masked, view_index, true, entry);
}
