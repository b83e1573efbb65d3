// Cluster rasteriser, one cluster per workgroup: threads project vertices, then draw triangles. Small
// triangles are drawn by their thread; larger ones are queued as tiles.
// Variants: FIRE3DV_SAMPLES 1 or 4. FIRE3DV_LIGHTS draws shadow maps; FIRE3DV_CENTER_MAPS_ONLY omits the outer
// maps. FIRE3DV_ALPHA_MASK tests alpha. FIRE3DV_CPU: one vector processes vertices, then triangles.
// FIRE3DV_NARROW has half as many threads with two triangles each, which is faster with enough clusters to
// fill the device.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "visibility/interleaved_groups.glsl"
#include "visibility/large_triangles.glsl"
#include "visibility/small_triangles.glsl"

#if defined(FIRE3DV_CPU)
const uint kThreads = 8;
layout(local_size_x = 8) in;
#elif defined(FIRE3DV_NARROW)
const uint kThreads = 64;
layout(local_size_x = 64) in;
#else
const uint kThreads = 128;
layout(local_size_x = 128) in;
#endif
layout(push_constant, scalar) uniform Push { RasterPush push; };
uint view_index;  // of the group; with several views in one dispatch, its z
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

// kNowhere: the triangle needs clipping.
ScreenVertex corner_of(RasterView view, vec3 world) {
  const vec2 size = vec2(view.width, view.height);
  const vec4 clip = clip_position(view.clip_from_world, world);
  if (!can_be_projected(clip, size)) return ScreenVertex(kNowhere, 0);
  return project(clip, size);
}

uint cluster_count(RasterSet set) {
#ifdef FIRE3DV_ALPHA_MASK
  const ClusterList list = ViewWorkRef(set.work).at[view_index].masked;
#else
  const ClusterList list = ViewWorkRef(set.work).at[view_index].solid;
#endif
  return max(list.groups_x, list.count);
}

// Cluster index, and FIRE3DV_LISTED_ONE_SIDE.
uint listed_at(RasterSet set, uint entry) {
#ifdef FIRE3DV_ALPHA_MASK
  const uint slot = set.instance_count - 1 - entry;
#else
  const uint slot = entry;
#endif
  return UintsRef(set.lists).at[view_index * set.instance_count + slot];
}

struct ShownCluster {
  uint number;
  bool one_side;
  bool mirrored;
};

ShownCluster shown_cluster(uint listed, AffineRows world_from_node) {
  return ShownCluster(listed & ~FIRE3DV_LISTED_ONE_SIDE, (listed & FIRE3DV_LISTED_ONE_SIDE) != 0, is_mirroring(world_from_node));
}

#ifdef FIRE3DV_LIGHTS
// For parts whose maps hold back faces only. Nearly edge-on triangles count as both sides, so that none is
// missing. Vertices are snapped by up to half a step, which bounds the error of twice the area.
bool faces_light(ivec2 ab, ivec2 ac, bool mirrored) {
  const int64_t area = int64_t(ab.x) * ac.y - int64_t(ab.y) * ac.x;
  return (mirrored ? area : -area) > abs(ab.x) + abs(ab.y) + abs(ac.x) + abs(ac.y) + 2;
}
#endif

void draw_triangle(GlobalsRef globals, RasterSet set, RasterView view, ShownCluster cluster, uint number, ScreenVertex a, ScreenVertex b,
                   ScreenVertex c) {
  const uint id = ((cluster.number + 1) << 7) | number;
  if (a.xy == kNowhere || b.xy == kNowhere || c.xy == kNowhere) {
    emit_huge(set, HugeTriangle(id, view_index));
    return;
  }
  ivec2 low, high;
  const ivec2 low_corner = min(a.xy, min(b.xy, c.xy)), high_corner = max(a.xy, max(b.xy, c.xy));
  covered_pixels(low_corner, high_corner, pixel_reach(view), ivec2(view.width, view.height), low, high);
  if (low.x > high.x || low.y > high.y) return;

  const ivec2 ab = b.xy - a.xy, ac = c.xy - a.xy, extent = high_corner - low_corner, box = high - low + 1;
#ifdef FIRE3DV_LIGHTS
  if (cluster.one_side && faces_light(ab, ac, cluster.mirrored)) return;
  const bool double_sided = true;
#else
  const bool double_sided = !cluster.one_side;
#endif
  if (max(extent.x, extent.y) > kMaxExtent || box.x * box.y > kMaxPixels) {
    emit_large(set, HugeTriangle(id, view_index), a, b, c, cluster.mirrored, double_sided, low, high, view);
    return;
  }
  int area = ab.x * ac.y - ab.y * ac.x;
#ifndef FIRE3DV_KEEPS_LINES
  // counter-clockwise is the front
  if (area == 0 || (!double_sided && (area > 0) != cluster.mirrored)) return;
#endif
  if (area < 0) {
    const ScreenVertex swapped = b;
    b = c;
    c = swapped;
    area = -area;
  }
  draw_small(globals, set, view, a, b, c, area, id, low, high);
}

shared ivec2 corner_xy[128];
shared float corner_z[128];

void find_corners(GlobalsRef globals, RasterView view, ClusterInstance instance, AffineRows world_from_node) {
  const uint vertex_count = instance.counts & 0xffff;
  for (uint vertex = gl_LocalInvocationIndex; vertex < vertex_count; vertex += kThreads) {
    const vec3 node = PositionRef(globals.value.positions).at[instance.first_vertex + vertex];
    const ScreenVertex corner = corner_of(view, world_position(world_from_node, node));
    corner_xy[vertex] = corner.xy;
    corner_z[vertex] = corner.z;
  }
}

// packed: indices of its vertices.
void draw_from_corners(GlobalsRef globals, RasterSet set, RasterView view, ShownCluster cluster, uint number, uint packed) {
  const uvec3 at = uvec3(packed & 255, (packed >> 8) & 255, (packed >> 16) & 255);
  draw_triangle(globals, set, view, cluster, number, ScreenVertex(corner_xy[at.x], corner_z[at.x]), ScreenVertex(corner_xy[at.y], corner_z[at.y]),
                ScreenVertex(corner_xy[at.z], corner_z[at.z]));
}

#ifdef FIRE3DV_CPU
// One vector processes the cluster.
void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  view_index = push.view;
  if (kSeveralWorlds) {
    view_index = gl_WorkGroupID.z;
    if (list_group() >= cluster_count(set)) return;  // the list of another view is longer
    globals = globals_of_view(set, view_index);
  }
  // Groups beyond the list redraw its last cluster, which changes nothing: reads outside of branches are
  // cheaper.
  const uint listed = listed_at(set, min(list_group(), cluster_count(set) - 1));
  const ClusterInstance instance = instance_for_all(globals.value.cluster_instances, listed & ~FIRE3DV_LISTED_ONE_SIDE);
  const AffineRows world_from_node = affine_for_all(globals.value.world_from_node, instance.node);
  const RasterView view = view_for_all(set.views, view_index);
  find_corners(globals, view, instance, world_from_node);
  subgroupBarrier();  // orders memory within one vector; no thread waits
  const ShownCluster cluster = shown_cluster(listed, world_from_node);
  const uint triangle_count = is_ended() ? 0 : instance.counts >> 16;
  for (uint number = gl_LocalInvocationIndex; number < triangle_count; number += kThreads) {
    const uint packed = UintRef(globals.value.cluster_triangles).at[instance.first_triangle + number];
    draw_from_corners(globals, set, view, cluster, number, packed);
  }
}
#else
void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  view_index = kSeveralWorlds ? gl_WorkGroupID.z : push.view;
  const uint entry = list_group(), thread = gl_LocalInvocationIndex;
  if (entry >= cluster_count(set)) return;  // the whole group
  if (kSeveralWorlds) globals = globals_of_view(set, view_index);
  const uint listed = listed_at(set, entry);
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[listed & ~FIRE3DV_LISTED_ONE_SIDE];
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[instance.node];
  const RasterView view = RasterViewRef(set.views).at[view_index];
  const uint triangle_count = instance.counts >> 16;
  const bool ended = is_ended();
  uint packed[128 / kThreads];
  for (uint i = 0; i < 128 / kThreads; ++i) {  // prefetched before the barrier
    const uint number = thread + i * kThreads;
    if (number < triangle_count) packed[i] = UintRef(globals.value.cluster_triangles).at[instance.first_triangle + number];
  }
  find_corners(globals, view, instance, world_from_node);
  barrier();
  if (ended) return;  // beyond the barrier: threads may see the word change
  const ShownCluster cluster = shown_cluster(listed, world_from_node);
  for (uint i = 0; i < 128 / kThreads; ++i) {
    const uint number = thread + i * kThreads;
    if (number >= triangle_count) return;
    draw_from_corners(globals, set, view, cluster, number, packed[i]);
  }
}
#endif
