// Conservative shadow test by shadow maps: lit, shadowed or unresolved. See docs/design/shadows.md.
// Each view of a light has two maps of the same triangles. The centre map has the nearest depth at each
// texel's centre. The outer map has the nearest depth anywhere in the texel (outer-conservative raster).
// Closed meshes are drawn with back faces only (see casts_by_back_faces()), so that a lit surface does not
// shadow itself.
#ifndef FIRE3DV_SHADOW_MAPS_GLSL
#define FIRE3DV_SHADOW_MAPS_GLSL
#include "common/generations.glsl"
#include "shading/lights.glsl"
#include "visibility/planar_casters.glsl"

const uint kLit = 0, kShadowed = 1, kUnresolved = 2;

struct ShadowMapPoint {
  RasterView view;
  vec2 texel;
  float depth;
  bool inside;
  vec2 reach;      // in texels: bound of the point's rounding error against the casters
  float rounding;  // of the depths
};

uint side_of_cube(vec3 direction) {
  const vec3 size = abs(direction);
  if (size.x >= size.y && size.x >= size.z) return direction.x > 0 ? 0 : 1;
  if (size.y >= size.z) return direction.y > 0 ? 2 : 3;
  return direction.z > 0 ? 4 : 5;
}

RasterView view_of(GlobalsRef globals, LightShadow shadow, LightSample light) {
  const uint side = shadow.view_count == 6 ? side_of_cube(-light.to_light) : 0;
  return RasterViewRef(globals.value.light_views).at[shadow.first_view + side];
}

ShadowMapPoint shadow_map_point(RasterView view, vec3 point_world) {
  ShadowMapPoint at;
  at.view = view;
  const vec4 clip = at.view.clip_from_world * vec4(point_world, 1);
  at.inside = clip.w > 0 && all(lessThan(abs(clip.xy), vec2(clip.w)));
  at.texel = (clip.xy / clip.w * 0.5 + 0.5) * float(at.view.width);
  at.depth = clip.z / clip.w;
  // Rounding grows with the distance from the world's origin. The maps are dilated by 1/256 texel.
  const mat4 m = at.view.clip_from_world;
  const vec4 error =
      6e-7 * (abs(m[0] * point_world.x) + abs(m[1] * point_world.y) + abs(m[2] * point_world.z) + abs(m[3]));
  at.reach = max((error.xy + error.w) / clip.w * 0.5 * float(at.view.width) - 1.0 / 256, vec2(0));
  at.rounding = at.view.eye_world.w == 0 ? 1e-5 + error.z : at.depth * (1e-5 + 2 * error.w / clip.w);
  return at;
}

// Two adjacent texels of a row, at any texel's address.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TexelsRef { uvec2 at; };

// An encode_depth() value. Comparisons work on this encoding, so only their result is decoded.
uint map_texel(GlobalsRef globals, RasterView view, ivec2 texel, bool outer) {
  texel = clamp(texel, ivec2(0), ivec2(view.width - 1));
  const uint index = view.first_texel + (outer ? view.width * view.width : 0) + uint(texel.y) * view.width + texel.x;
  return UintRef(globals.value.shadow_maps).at[index];
}

// Distance by which `depth` is nearer to the light than the point, in metres.
float nearer_by_m(ShadowMapPoint at, float depth) {
  if (at.view.eye_world.w == 0) return (depth - at.depth) * at.view.depth_m;
  return at.view.depth_m / at.depth - at.view.depth_m / max(depth, 1e-20);
}

// Depth of a point that is by_m metres nearer to the light than the point.
float depth_nearer_by(ShadowMapPoint at, float by_m) {
  if (at.view.eye_world.w == 0) return at.depth + by_m / at.view.depth_m;
  const float left_m = at.view.depth_m / at.depth - by_m;
  return left_m > 0 ? at.view.depth_m / left_m : 1e30;
}

// Height of the receiver's plane over one texel, along the light's direction.
float slope_m(ShadowMapPoint at, vec3 plane_normal, vec3 to_light) {
  const float cosine = max(abs(dot(plane_normal, to_light)), 0.02);
  const float texel_m = at.view.eye_world.w == 0 ? at.view.texel_m : at.view.texel_m * at.view.depth_m / at.depth;
  return texel_m * sqrt(1 - min(cosine * cosine, 1.0)) / cosine + (at.view.level_scale > 0 ? 0.35 : 0.1) * texel_m;
}

// Lit, for certain: the outer map has nothing nearer to the light than the point.
// Shadowed: all 3 x 3 texel centres are clearly nearer. Light through holes below about two texels is lost.
// Unknown otherwise: a ray decides.
uint shadow_map_test(GlobalsRef globals, RasterView view, uint part, vec3 point_world, vec3 plane_normal, LightSample light) {
  const bool caster = planar_caster_may_be_between(globals, part, point_world, light.to_light, light.distance_m);
  const ShadowMapPoint at = shadow_map_point(view, point_world);
  // A map covers all casters; a spot light's map covers its cone.
  if (!at.inside) return caster ? kUnresolved : kLit;
  if (max(at.reach.x, at.reach.y) > 0.5) return kUnresolved;
  const ivec2 texel = ivec2(floor(at.texel));
  const ivec2 low = ivec2(floor(at.texel - at.reach)), high = ivec2(floor(at.texel + at.reach));
  // The reach is below one texel, so these are all texels. Mostly it is one; loops would cost more than the
  // reads.
  uint nearest = map_texel(globals, at.view, low, true);
  if (low != high) {
    nearest = max(max(nearest, map_texel(globals, at.view, ivec2(high.x, low.y), true)),
                  max(map_texel(globals, at.view, ivec2(low.x, high.y), true), map_texel(globals, at.view, high, true)));
  }
  const float outer = decode_depth(nearest, globals.value.map_generation);
  if (outer == 0 || outer < at.depth - at.rounding) return caster ? kUnresolved : kLit;
  const float clearly_m = 2 * slope_m(at, plane_normal, light.to_light);
  uint least = map_texel(globals, at.view, texel, false);
  for (int i = 0; i < 4; ++i) {
    const ivec2 offset = ivec2(i < 3 ? -1 : 0, i < 3 ? i - 1 : -1);  // and its opposite
    least = min(least, min(map_texel(globals, at.view, texel + offset, false), map_texel(globals, at.view, texel - offset, false)));
  }
  const float farthest = decode_depth(least, globals.value.map_generation);
  return farthest != 0 && nearer_by_m(at, farthest) >= clearly_m ? kShadowed : kUnresolved;
}

// Four texels around a point and their bilinear weights.
struct FilterTexels {
  uvec4 at;  // encode_depth() values
  vec2 weight;
};

FilterTexels filter_texels(GlobalsRef globals, ShadowMapPoint at) {
  // Two texels of a row per read halve the address arithmetic.
  const ivec2 first = clamp(ivec2(floor(at.texel - 0.5)), ivec2(0), ivec2(at.view.width - 2));
  const uint64_t row = globals.value.shadow_maps + uint64_t(4 * (at.view.first_texel + uint(first.y) * at.view.width + first.x));
  return FilterTexels(uvec4(TexelsRef(row).at, TexelsRef(row + 4 * at.view.width).at), clamp(at.texel - 0.5 - vec2(first), 0, 1));
}

float filtered(FilterTexels texels, vec4 values) {
  const vec2 along_x = mix(values.xz, values.yw, texels.weight.x);
  return mix(along_x.x, along_x.y, texels.weight.y);
}

// Depth for comparisons with the stored encoding. Empty texels have depth 0; the clamp also covers points beyond the
// map's depth range.
uint encoded_nearer_by(GlobalsRef globals, ShadowMapPoint at, float by_m) {
  return encode_depth(clamp(depth_nearer_by(at, by_m), 1e-30, kMaxDepth), globals.value.map_generation);
}

// Shadow maps without rays: percentage-closer filtering of four texels.
float map_visibility(GlobalsRef globals, RasterView view, vec3 point_world, vec3 plane_normal, LightSample light) {
  const ShadowMapPoint at = shadow_map_point(view, point_world);
  if (!at.inside) return 1;
  const float bias_m = 1.5 * slope_m(at, plane_normal, light.to_light);
  const FilterTexels texels = filter_texels(globals, at);
  return filtered(texels, vec4(lessThan(texels.at, uvec4(encoded_nearer_by(globals, at, bias_m)))));
}

float map_visibility(GlobalsRef globals, LightShadow shadow, vec3 point_world, vec3 plane_normal, LightSample light) {
  if (shadow.rays == 0) return 1;
  return map_visibility(globals, view_of(globals, shadow, light), point_world, plane_normal, light);
}

#endif
