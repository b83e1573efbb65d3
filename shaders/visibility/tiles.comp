// Tile rasteriser: one tile of one large triangle per workgroup. Variants: FIRE3DV_SAMPLES 1 or 4;
// FIRE3DV_LIGHTS.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "visibility/tile_raster.glsl"

layout(local_size_x = kTileThreads) in;
layout(push_constant, scalar) uniform Push { RasterPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

void main() {
  GlobalsRef globals = globals_at(push.globals);
  RasterSet set = RasterSetRef(push.set).value;
  const uint slot = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (slot >= min(LargeWorkRef(set.large).value.tiles.count, set.tile_capacity) || is_ended()) return;
  const TileEntry entry = TileEntryRef(set.tiles).at[slot];
  const PreparedTriangle prepared = PreparedTriangleRef(set.prepared).at[entry.prepared];
  if (kSeveralWorlds) globals = globals_of_view(set, prepared.view);
  const RasterView view = RasterViewRef(set.views).at[prepared.view];
  const TileTriangle triangle = tile_triangle(prepared);
  const ivec2 origin = ivec2(entry.tile & 0xffffu, entry.tile >> 16) << kTileShift;
#ifndef FIRE3DV_LIGHTS
  if (!is_masked(globals, triangle.id)) {
    draw_tile_rows(set, view, triangle, origin, gl_LocalInvocationIndex);
    return;
  }
#endif
  for (uint i = gl_LocalInvocationIndex; i < 1u << (2 * kTileShift); i += kTileThreads) {
    draw_tile_pixel(globals, set, view, triangle,
                    origin + ivec2(i & ((1 << kTileShift) - 1), i >> kTileShift));
  }
}
