// Expansion of huge triangles, one per workgroup: clips against near plane and guard band, then lists tiles.
// Variants: FIRE3DV_SAMPLES 1 or 4; FIRE3DV_LIGHTS.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "visibility/clip_polygon.glsl"
#include "visibility/culling.glsl"
#include "visibility/large_triangles.glsl"
#include "visibility/tile_raster.glsl"

const int kThreads = 256;  // a ground plane covers as many tiles as the image
layout(local_size_x = kThreads) in;
layout(push_constant, scalar) uniform Push { RasterPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

shared uint shared_slot;
const uint kEnded = FIRE3DV_NO_INDEX - 1;

void list_tiles(GlobalsRef globals, RasterSet set, RasterView view, PreparedTriangle prepared) {
  const ivec2 size = ivec2(view.width, view.height);
  barrier();  // all lanes have read the earlier triangle's index
  if (gl_LocalInvocationIndex == 0) {
    if (is_ended()) {
      shared_slot = kEnded;
    } else {
      const uint slot = atomicAdd(LargeWorkRef(set.large).value.prepared_count, 1);
      shared_slot = slot < set.prepared_capacity ? slot : FIRE3DV_NO_INDEX;
      if (slot < set.prepared_capacity) PreparedTriangleRef(set.prepared).at[slot] = prepared;
    }
  }
  barrier();
  const uint slot = shared_slot;
  if (slot == kEnded) return;
  ivec2 low, high;
  covered_pixels(min(prepared.a, min(prepared.b, prepared.c)), max(prepared.a, max(prepared.b, prepared.c)),
                 pixel_reach(view), size, low, high);
  if (low.x > high.x || low.y > high.y) return;
  const ivec2 first = low >> kTileShift, tiles = (high >> kTileShift) - first + 1;
  const int count = tiles.x * tiles.y;
  for (int from = 0; from < count; from += 32 * kThreads) {
    uint reached = 0;  // bit mask over the lane's tiles, which are kThreads apart
    for (int i = 0; i < 32; ++i) {
      const int number = from + kThreads * i + int(gl_LocalInvocationIndex);
      if (number >= count) break;
      const ivec2 origin = (first + ivec2(number % tiles.x, number / tiles.x)) << kTileShift;
      if (reaches_box(prepared, origin, origin + (1 << kTileShift) - 1)) reached |= 1u << i;
    }
    // One atomic reserves the entries of a subgroup.
    const uint own = bitCount(reached), all = subgroupAdd(own);
    uint entry = 0;
    if (subgroupElect() && slot != FIRE3DV_NO_INDEX && all != 0) entry = slots_for_tiles(set, all);
    entry = subgroupBroadcastFirst(entry) + subgroupExclusiveAdd(own);
    for (; reached != 0; reached &= reached - 1, ++entry) {
      const int number = from + kThreads * findLSB(reached) + int(gl_LocalInvocationIndex);
      const ivec2 tile = first + ivec2(number % tiles.x, number / tiles.x);
      if (slot != FIRE3DV_NO_INDEX && emit_tile(set, entry, slot, tile, view)) continue;
      // On overflow the lane draws the tile itself: slow, but the same image.
      const TileTriangle triangle = tile_triangle(prepared);
      const ivec2 origin = tile << kTileShift;
      for (int p = 0; p < 1 << (2 * kTileShift); ++p) {
        draw_tile_pixel(globals, set, view, triangle, origin + ivec2(p & ((1 << kTileShift) - 1), p >> kTileShift));
      }
    }
  }
}

void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  const uint entry = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (entry >= min(LargeWorkRef(set.large).value.expand.count, set.huge_capacity)) return;
  const HugeTriangle huge = HugeTriangleRef(set.huge).at[entry];
  if (kSeveralWorlds) globals = globals_of_view(set, huge.view);
  const VisibleTriangle triangle = visible_triangle(globals, huge.id);
  const RasterView view = RasterViewRef(set.views).at[huge.view];
  const ivec2 size = ivec2(view.width, view.height);
  const bool mirrored = (triangle.node_facts & FIRE3DV_NODE_MIRRORED) != 0;
  const vec3 normal = cross(triangle.world[1] - triangle.world[0], triangle.world[2] - triangle.world[0]);
  if (draws_one_side(globals, part_of_id(globals, huge.id), triangle.part) &&
      !shows_side(view, mirrored ? -normal : normal, triangle.world[0])) {
    return;
  }
#ifdef FIRE3DV_LIGHTS
  const bool double_sided = true;
#else
  const bool double_sided = (triangle.part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0;
#endif

  vec4 corners[kMaxClipVertices];
  int count = 3;
  bool whole = true;
  for (int i = 0; i < 3; ++i) {
    corners[i] = clip_position(view.clip_from_world, triangle.world[i]);
    whole = whole && can_be_projected(corners[i], vec2(size));
  }
  if (!whole) cut_to_view(corners, count, vec2(size));
  if (count < 3) return;
  const ScreenVertex a = project(corners[0], vec2(size));
  for (int i = 2; i < count; ++i) {
    PreparedTriangle prepared;
    const ScreenVertex b = project(corners[i - 1], vec2(size)), c = project(corners[i], vec2(size));
    if (prepare(huge, a, b, c, mirrored, double_sided, prepared)) list_tiles(globals, set, view, prepared);
  }
}
