// Coverage rule of all raster paths: vertices snapped to 1/256 pixel, exact integer edge functions, the
// top-left rule. Adjacent triangles neither overlap nor leave gaps. A triangle drawn by one thread or in
// tiles yields identical bits.
#ifndef FIRE3DV_RASTER_RULES_GLSL
#define FIRE3DV_RASTER_RULES_GLSL
#include "common/buffers.glsl"

// A light's outer map holds everything that touches a texel, including degenerate lines.
#if defined(FIRE3DV_LIGHTS) && !defined(FIRE3DV_CENTER_MAPS_ONLY)
#define FIRE3DV_KEEPS_LINES
#endif

const int kSubpixels = 256;
const int kHalfPixel = 128;
const int kTileShift = int(FIRE3DV_TILE_SHIFT);
// Index of a tile's triangle list in the per-tile variants. Views are stored in sequence.
uint list_of_tile(RasterView view, ivec2 tile) {
  const uint tiles_across = (view.width + (1u << kTileShift) - 1) >> kTileShift;
  return view.first_tile + uint(tile.y) * tiles_across + uint(tile.x);
}
// Vertices beyond half of this from the image's centre are clipped, so that edge functions fit 64 bits.
const float kGuardPixels = 1048576;
const ivec2 kNowhere = ivec2(-2147483647);

// Globals of a view's world, in sets of several worlds.
GlobalsRef globals_of_view(RasterSet set, uint view) { return globals_at(AddressRef(set.view_globals).at[view]); }

struct ScreenVertex {
  ivec2 xy;  // 1/256 pixel
  float z;   // reversed depth
};

// Uses the clip planes bit for bit: an edge between two projectable vertices is never clipped. It is
// therefore identical in both of its triangles.
bool can_be_projected(vec4 clip, vec2 size) {
  precise const vec2 guard = kGuardPixels / size * clip.w;
  // z <= w is the near plane, and there w > 0.
  return clip.w > 0 && clip.z <= clip.w && all(lessThanEqual(abs(clip.xy), guard));
}

// Bounds a vertex's depth, also for NaN positions: stored depths must lie between 0 and 2, see
// generations.glsl. Camera views keep depths beyond the far plane, which the samples discard.
float bounded_depth(float z) {
#ifdef FIRE3DV_LIGHTS
  return z > 0 ? min(z, 1.0) : 0;
#else
  return z > 0 ? min(z, 1.0) : z < 0 ? max(z, -1e30) : z == 0 ? 0 : -1;
#endif
}

ScreenVertex project(vec4 clip, vec2 size) {
  precise const vec2 ndc = clip.xy / clip.w;
  precise const vec2 pixel = (ndc * 0.5 + 0.5) * size;
  precise const vec2 steps = floor(pixel * float(kSubpixels) + 0.5);
  precise const float z = clip.z / clip.w;
  ScreenVertex corner;
  corner.xy = ivec2(steps);
  corner.z = bounded_depth(z);
  return corner;
}

vec4 clip_position(mat4 clip_from_world, vec3 world) {
  precise const vec4 clip = clip_from_world * vec4(world, 1);
  return clip;
}

vec3 world_position(AffineRows world_from_node, vec3 node) {
  precise const vec3 world = transform_point(world_from_node, node);
  return world;
}

// 0: the edge owns samples on it; 1: it does not. Positive area, y down.
int edge_bias(ivec2 from, ivec2 to) {
  const ivec2 d = to - from;
  return d.y < 0 || (d.y == 0 && d.x > 0) ? 0 : 1;
}

// Vulkan's standard sample positions.
#ifndef FIRE3DV_SAMPLES
#define FIRE3DV_SAMPLES 1
#endif
#if FIRE3DV_SAMPLES == 4
const ivec2 kSamplePosition[4] = ivec2[4](ivec2(96, 32), ivec2(224, 96), ivec2(32, 160), ivec2(160, 224));
const int kFirstSample = 32, kLastSample = 224;  // outermost positions, in both directions
#else
const ivec2 kSamplePosition[1] = ivec2[1](ivec2(128, 128));
const int kFirstSample = 128, kLastSample = 128;
#endif

// Pixels with a sample in the vertices' bounding box; empty when high < low. reach: of a light's map, beyond
// the box, in 1/256.
void covered_pixels(ivec2 low_corner, ivec2 high_corner, int reach, ivec2 size, out ivec2 low, out ivec2 high) {
#ifdef FIRE3DV_KEEPS_LINES
  low_corner -= reach;  // texels that are certainly touched
  high_corner += reach;
  low = max(low_corner >> 8, ivec2(0));
  high = min(high_corner >> 8, size - 1);
#else
  low = max((low_corner + (kSubpixels - 1 - kLastSample)) >> 8, ivec2(0));
  high = min((high_corner - kFirstSample) >> 8, size - 1);
#endif
}

#endif
