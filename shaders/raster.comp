// One cluster for each workgroup: a vertex, then a triangle for each thread. Small triangles are drawn by their thread;
// larger ones go to the tiles.
// Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_LIGHTS draws lights' maps, with FIRE3DV_MIDDLES_ALONE not
// the outer ones; FIRE3DV_ALPHA_MASK tests the surface's alpha.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef FIRE3DV_LIGHTS
#include "common/light_raster.glsl"
#else
#include "common/camera_raster.glsl"
#endif
#include "common/culling.glsl"
#include "common/large_triangles.glsl"

layout(local_size_x = 128) in;
layout(push_constant, scalar) uniform Push { RasterPush push; };

#ifndef FIRE3DV_CPU
shared ivec2 corner_xy[128];
shared float corner_z[128];
shared vec3 corner_world[128];
#endif

const int kMostPixels = 256;            // of a box that one thread walks through
const int kMostExtent = 64 * kSubpixels;  // so that edge functions fit 32 bits

void draw_small(GlobalsRef globals, RasterSet set, RasterView view, Corner a, Corner b, Corner c, int area, uint id,
                ivec2 low, ivec2 high) {
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const ivec3 bias = ivec3(edge_bias(b.xy, c.xy), edge_bias(c.xy, a.xy), edge_bias(a.xy, b.xy));
  precise const float inverse_area = 1 / float(area);
#ifdef FIRE3DV_LIGHTS
  const MapTarget target = map_target(set, view);
#ifndef FIRE3DV_MIDDLES_ALONE
  const bool has_area = area > 0;
  const bool is_broad = is_broad_triangle(float(area), ab, bc, ca);
  const int reach = reach_of(view);
#endif
#endif
#ifdef FIRE3DV_ALPHA_MASK
  const VisibleTriangle triangle = seen_from(visible_triangle(globals, id), view);
#endif
#ifdef FIRE3DV_CPU
  // One loop: in two, every row would take as long as the widest triangle of a vector.
  for (int x = low.x, y = low.y; y <= high.y; y += x == high.x ? 1 : 0, x = x == high.x ? low.x : x + 1) {
    {
#else
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
#endif
#ifdef FIRE3DV_LIGHTS
      const ivec2 texel = ivec2(x, y);
      FIRE3DV_COVER_TEXEL(int, ivec2)
#ifndef FIRE3DV_MIDDLES_ALONE
      if (!touches) continue;
      put_nearest(target, texel, true, nearest_possible(view, outer));
#endif
#ifdef FIRE3DV_ALPHA_MASK
      if (!is_solid_at(globals, triangle, vec2(texel) + 0.5, vec2(view.width))) continue;
#endif
      if (middle) put_nearest(target, texel, false, z);
#else
      const ivec2 pixel = ivec2(x, y);
      FIRE3DV_COVER_PIXEL(int, ivec2)
      if (covered == 0) continue;
#ifdef FIRE3DV_ALPHA_MASK
      if (!is_solid_at(globals, triangle, tested_place(pixel, covered), vec2(view.width, view.height))) continue;
#endif
      const uint first = view.first_texel + uint(y * int(view.width) + x) * FIRE3DV_SAMPLES;
      for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
        if ((covered & (1u << s)) != 0) put(set.target, first + s, depth[s], id, false);
      }
#endif
    }
  }
}

// kNowhere: of a triangle that has to be cut first.
Corner corner_of(RasterView view, vec3 world) {
  const vec2 size = vec2(view.width, view.height);
  const vec4 clip = clip_position(view.clip_from_world, world);
  if (!can_be_projected(clip, size)) return Corner(kNowhere, 0);
  return project(clip, size);
}

void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  uint entry = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
#ifdef FIRE3DV_ALPHA_MASK
  const uint count = ViewWorkRef(set.work).at[push.view].masked.count;
#else
  const uint count = ViewWorkRef(set.work).at[push.view].solid.count;
#endif
#ifdef FIRE3DV_CPU
  entry = min(entry, count - 1);  // drawn again, which changes nothing: outside of branches reading costs less
#else
  if (entry >= count) return;  // the whole group
#endif

#ifdef FIRE3DV_ALPHA_MASK
  const uint place = set.instance_count - 1 - entry;
#else
  const uint place = entry;
#endif
  const uint listed = UintsRef(set.lists).at[push.view * set.instance_count + place];
  const uint cluster_index = listed & ~FIRE3DV_LISTED_ONE_SIDE;
  const bool one_side = (listed & FIRE3DV_LISTED_ONE_SIDE) != 0;
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[cluster_index];
#ifdef FIRE3DV_CPU
  const PartRecord part = part_for_all(globals.value.parts, instance.part);
  const ClusterRecord cluster = cluster_for_all(globals.value.clusters, instance.cluster);
  const AffineRows world_from_node = affine_for_all(globals.value.world_from_node, part.node);
  const RasterView view = view_for_all(set.views, push.view);
#else
  const PartRecord part = PartRef(globals.value.parts).at[instance.part];
  const ClusterRecord cluster = ClusterRef(globals.value.clusters).at[instance.cluster];
  const AffineRows world_from_node = AffineRowsRef(globals.value.world_from_node).at[part.node];
  const RasterView view = RasterViewRef(set.views).at[push.view];
#endif
  const ivec2 size = ivec2(view.width, view.height);
  const uint thread = gl_LocalInvocationIndex;

#ifdef FIRE3DV_CPU
  // Each lane finds its three corners: waiting for the others takes longer.
  if (thread >= cluster.triangle_count) return;
  const uint packed = UintRef(globals.value.cluster_triangles).at[cluster.first_triangle + thread];
  const uvec3 corners = cluster.first_vertex + uvec3(packed & 255, (packed >> 8) & 255, (packed >> 16) & 255);
  const vec3 wa = world_position(world_from_node, PositionRef(globals.value.positions).at[corners.x]);
  const vec3 wb = world_position(world_from_node, PositionRef(globals.value.positions).at[corners.y]);
  const vec3 wc = world_position(world_from_node, PositionRef(globals.value.positions).at[corners.z]);
  Corner a = corner_of(view, wa), b = corner_of(view, wb), c = corner_of(view, wc);
#else
  if (thread < cluster.vertex_count) {
    const vec3 world = world_position(world_from_node, PositionRef(globals.value.positions).at[cluster.first_vertex + thread]);
    const Corner corner = corner_of(view, world);
    corner_xy[thread] = corner.xy;
    corner_z[thread] = corner.z;
    corner_world[thread] = world;
  }
  // Asked for before the others are waited for.
  uint packed = 0;
  if (thread < cluster.triangle_count) packed = UintRef(globals.value.cluster_triangles).at[cluster.first_triangle + thread];
  barrier();
  if (thread >= cluster.triangle_count) return;

  const uvec3 local = uvec3(packed & 255, (packed >> 8) & 255, (packed >> 16) & 255);
  Corner a = Corner(corner_xy[local.x], corner_z[local.x]);
  Corner b = Corner(corner_xy[local.y], corner_z[local.y]);
  Corner c = Corner(corner_xy[local.z], corner_z[local.z]);
  const vec3 wa = corner_world[local.x], wb = corner_world[local.y], wc = corner_world[local.z];
#endif
  const uint id = ((cluster_index + 1) << 7) | thread;
  if (a.xy == kNowhere || b.xy == kNowhere || c.xy == kNowhere) {
    emit_huge(set, HugeTriangle(id, push.view));
    return;
  }

  ivec2 low, high;
  const ivec2 low_corner = min(a.xy, min(b.xy, c.xy)), high_corner = max(a.xy, max(b.xy, c.xy));
  covered_pixels(low_corner, high_corner, pixel_reach(view), size, low, high);
  if (low.x > high.x || low.y > high.y) return;

  const vec3 r0 = world_from_node.row0.xyz, r1 = world_from_node.row1.xyz, r2 = world_from_node.row2.xyz;
  const bool mirrored = dot(r0, cross(r1, r2)) < 0;
  const vec3 normal = cross(wb - wa, wc - wa);
  if (one_side && !shows_side(view, mirrored ? -normal : normal, wa)) return;
#ifdef FIRE3DV_LIGHTS
  const bool double_sided = true;
#else
  const bool double_sided = (part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0;
#endif
  const ivec2 extent = high_corner - low_corner, box = high - low + 1;
  if (max(extent.x, extent.y) > kMostExtent || box.x * box.y > kMostPixels) {
    emit_large(set, HugeTriangle(id, push.view), a, b, c, mirrored, double_sided, low, high, view);
    return;
  }
  const ivec2 ab = b.xy - a.xy, ac = c.xy - a.xy;
  int area = ab.x * ac.y - ab.y * ac.x;
#ifndef FIRE3DV_KEEPS_LINES
  if (area == 0 || (!double_sided && (area > 0) != mirrored)) return;  // counter-clockwise is the front
#endif
  if (area < 0) {
    const Corner swapped = b;
    b = c;
    c = swapped;
    area = -area;
  }
  draw_small(globals, set, view, a, b, c, area, id, low, high);
}
