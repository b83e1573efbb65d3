// Writes to a light's two shadow maps; see shadow_maps.glsl. Nearest depths win; depth is reversed, so the
// largest. Variant FIRE3DV_CENTER_MAPS_ONLY omits the outer map, which only the ray-traced back ends read.
#ifndef FIRE3DV_LIGHT_RASTER_GLSL
#define FIRE3DV_LIGHT_RASTER_GLSL
#include "common/generations.glsl"
#include "common/visible_triangle.glsl"
#include "visibility/level_choice.glsl"

struct MapTarget {
  uint64_t maps;
  uint first_texel;
  uint size;
  bool read_before_write;
  uint generation;
};

MapTarget map_target(RasterSet set, RasterView view) {
  return MapTarget(set.target, view.first_texel, view.width, set.read_before_write != 0, set.generation);
}

// texel_index: index of the texel, row by row.
void put_nearest(MapTarget target, uint texel_index, bool outer, float depth) {
  const uint index = target.first_texel + (outer ? target.size * target.size : 0) + texel_index;
  const uint value = encode_depth(depth, target.generation);
  UintsRef maps = UintsRef(target.maps);
  if (!target.read_before_write || maps.at[index] < value) atomicMax(maps.at[index], value);
}

#ifdef FIRE3DV_CENTER_MAPS_ONLY
int pixel_reach(RasterView view) { return 0; }

// covers_center: the triangle covers the texel's centre, at depth z.
#define FIRE3DV_COVER_TEXEL(INT, IVEC)                                                                \
  const ivec2 position = texel * kSubpixels + kHalfPixel;                                                \
  const IVEC from_a = IVEC(position - a.xy), from_b = IVEC(position - b.xy), from_c = IVEC(position - c.xy);   \
  const INT wa = INT(bc.x) * from_b.y - INT(bc.y) * from_b.x;                                         \
  const INT wb = INT(ca.x) * from_c.y - INT(ca.y) * from_c.x;                                         \
  const INT wc = INT(ab.x) * from_a.y - INT(ab.y) * from_a.x;                                         \
  const float z = (float(wa) * a.z + float(wb) * b.z + float(wc) * c.z) * inverse_area;               \
  const bool covers_center = wa >= INT(bias.x) && wb >= INT(bias.y) && wc >= INT(bias.z);
#else
// Half a texel, plus two steps of rounding of vertices and points.
const int kReach = kHalfPixel + 2;

// Coarser LODs may differ from the ray-traced triangles by up to kLevelTexels.
int reach_of(RasterView view) {
  return view.level_scale > 0 ? kReach + int(ceil(kLevelTexels * kSubpixels)) + 1 : kReach;
}
int pixel_reach(RasterView view) { return reach_of(view) - kHalfPixel; }
float nearest_possible(RasterView view, float depth) {
  if (view.level_scale == 0) return depth;
  const float away_m = kLevelTexels * view.texel_m;  // in perspective at a distance of 1 m
  return min(view.eye_world.w == 0 ? depth + away_m / view.depth_m : depth * (1 + 1.05 * away_m), kMaxDepth);
}

// Parameters of a triangle's nearest depth anywhere in a texel, derived from its depth z at the texel's
// centre.
struct OuterDepth {
  float nearest, rise, rounding;
  bool is_broad;
};

OuterDepth outer_depth_of(ScreenVertex a, ScreenVertex b, ScreenVertex c, float inverse_area, int reach, bool is_broad) {
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const vec2 slope = abs(vec2(-bc.y, bc.x) * a.z + vec2(-ca.y, ca.x) * b.z + vec2(-ab.y, ab.x) * c.z) * inverse_area;
  OuterDepth depth;
  depth.nearest = max(a.z, max(b.z, c.z));
  depth.rise = (slope.x + slope.y) * (reach * 1.001);
  depth.rounding = 4e-6 * depth.nearest;
  depth.is_broad = is_broad;
  return depth;
}

float outer_depth(OuterDepth depth, float z) {
  return depth.is_broad ? min(depth.nearest, z + depth.rise + depth.rounding) : depth.nearest;
}

// reach: of the view. touches: the triangle reaches into the texel. covers_center: it covers the centre, at depth z.
// outer: bound of its nearest depth in the texel. A triangle without area touches the texels of its line.
#define FIRE3DV_COVER_TEXEL(INT, IVEC)                                                                              \
  const ivec2 position = texel * kSubpixels + kHalfPixel;                                                              \
  const IVEC from_a = IVEC(position - a.xy), from_b = IVEC(position - b.xy), from_c = IVEC(position - c.xy);                 \
  const INT wa = INT(bc.x) * from_b.y - INT(bc.y) * from_b.x;                                                       \
  const INT wb = INT(ca.x) * from_c.y - INT(ca.y) * from_c.x;                                                       \
  const INT wc = INT(ab.x) * from_a.y - INT(ab.y) * from_a.x;                                                       \
  const bool touches = wa + INT(abs(bc.x) + abs(bc.y)) * reach >= 0 &&                                             \
                       wb + INT(abs(ca.x) + abs(ca.y)) * reach >= 0 && wc + INT(abs(ab.x) + abs(ab.y)) * reach >= 0; \
  const float za = float(wa) * a.z, zb = float(wb) * b.z, zc = float(wc) * c.z;                                     \
  const float z = (za + zb + zc) * inverse_area;                                                                    \
  const bool covers_center = has_area && wa >= INT(bias.x) && wb >= INT(bias.y) && wc >= INT(bias.z);                      \
  const float outer = outer_depth(outer_depth_of(a, b, c, inverse_area, reach, is_broad), z);

// Broad enough that its plane bounds depths slightly outside of it.
bool is_broad_triangle(float area, ivec2 ab, ivec2 bc, ivec2 ca) {
  const ivec2 extent = max(abs(ab), max(abs(bc), abs(ca)));
  return area > 0 && area >= float(kSubpixels) * float(max(extent.x, extent.y));
}
#endif

#endif
