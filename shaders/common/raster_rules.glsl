// The one rule by which triangles cover samples, whatever draws them: corners on a grid of 1/256 pixel, exact integer
// edge functions, the top-left rule. So neighbours never overlap or leave a gap, and it makes no difference to a
// single bit whether a triangle is drawn by one thread or in tiles.
#ifndef FIRE3DV_RASTER_RULES_GLSL
#define FIRE3DV_RASTER_RULES_GLSL
#include "common/buffers.glsl"

// A light's outer map holds all that reaches into a texel, and so lines, too.
#if defined(FIRE3DV_LIGHTS) && !defined(FIRE3DV_MIDDLES_ALONE)
#define FIRE3DV_KEEPS_LINES
#endif

const int kSubpixels = 256;
const int kHalfPixel = 128;
const int kTileShift = int(FIRE3DV_TILE_SHIFT);
// Of the triangles of a tile, where tiles are drawn one by one. Those of several views lie one behind the other.
uint list_of_tile(RasterView view, ivec2 tile) {
  const uint tiles_across = (view.width + (1u << kTileShift) - 1) >> kTileShift;
  return view.first_tile + uint(tile.y) * tiles_across + uint(tile.x);
}
// Corners farther than half of this from the image's middle are cut off first, so that edge functions fit 64 bits.
const float kGuardPixels = 1048576;
const ivec2 kNowhere = ivec2(-2147483647);

struct Corner {
  ivec2 xy;  // 1/256 pixel
  float z;   // reversed depth
};

// The same planes, to the bit, as those that triangles are cut at: of an edge whose ends can both be projected nothing is
// ever cut, so that it runs the same way in both of its triangles.
bool can_be_projected(vec4 clip, vec2 size) {
  precise const vec2 guard = kGuardPixels / size * clip.w;
  // z <= w is the near plane, and there w > 0.
  return clip.w > 0 && clip.z <= clip.w && all(lessThanEqual(abs(clip.xy), guard));
}

// Of a corner that may come from places that are no numbers: what is drawn has to find depths between 0 and 2, see
// generations.glsl. For a camera there is something beyond the far plane, which is left out sample by sample.
float bounded_depth(float z) {
#ifdef FIRE3DV_LIGHTS
  return z > 0 ? min(z, 1.0) : 0;
#else
  return z > 0 ? min(z, 1.0) : z < 0 ? max(z, -1e30) : z == 0 ? 0 : -1;
#endif
}

Corner project(vec4 clip, vec2 size) {
  precise const vec2 ndc = clip.xy / clip.w;
  precise const vec2 pixel = (ndc * 0.5 + 0.5) * size;
  precise const vec2 steps = floor(pixel * float(kSubpixels) + 0.5);
  precise const float z = clip.z / clip.w;
  Corner corner;
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

// 0 for an edge that owns the samples on it, 1 for one that does not. Positive area, y down.
int edge_bias(ivec2 from, ivec2 to) {
  const ivec2 d = to - from;
  return d.y < 0 || (d.y == 0 && d.x > 0) ? 0 : 1;
}

// Where samples lie in a pixel: the standard positions of Vulkan.
#ifndef FIRE3DV_SAMPLES
#define FIRE3DV_SAMPLES 1
#endif
#if FIRE3DV_SAMPLES == 4
const ivec2 kSamplePosition[4] = ivec2[4](ivec2(96, 32), ivec2(224, 96), ivec2(32, 160), ivec2(160, 224));
const int kFirstSample = 32, kLastSample = 224;  // the outermost positions, in both directions
#else
const ivec2 kSamplePosition[1] = ivec2[1](ivec2(128, 128));
const int kFirstSample = 128, kLastSample = 128;
#endif

// Pixels that have a sample in the box of the corners; empty when high < low.
// reach: in 1/256, beyond the box, of a light's map.
void covered_pixels(ivec2 low_corner, ivec2 high_corner, int reach, ivec2 size, out ivec2 low, out ivec2 high) {
#ifdef FIRE3DV_KEEPS_LINES
  low_corner -= reach;  // texels that are touched, for certain
  high_corner += reach;
  low = max(low_corner >> 8, ivec2(0));
  high = min(high_corner >> 8, size - 1);
#else
  low = max((low_corner + (kSubpixels - 1 - kLastSample)) >> 8, ivec2(0));
  high = min((high_corner - kFirstSample) >> 8, size - 1);
#endif
}

#endif
