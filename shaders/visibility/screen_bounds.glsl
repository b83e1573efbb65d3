// Screen-space bounds of a sphere and the culling tests that use them: occlusion and small primitives. All
// bounds are conservative against rounding.
#ifndef FIRE3DV_SCREEN_BOUNDS_GLSL
#define FIRE3DV_SCREEN_BOUNDS_GLSL
#include "visibility/hiz.glsl"
#include "visibility/raster_rules.glsl"

struct ScreenBounds {
  vec2 low, high;  // pixels
  float nearest;   // reversed depth: maximum over the sphere
  bool known;      // false near the eye
};

// Extent of X / W over the sphere, from the two tangent planes X = u W. X = dot(x, p) + .. and W = dot(w, p)
// + .. are clip coordinates with values cx, cw at the centre.
vec2 touching_planes(vec3 x, vec3 w, float cx, float cw, float radius) {
  const float xw = dot(x, w), ww = dot(w, w), r2 = radius * radius;
  const vec3 across = cw * x - cx * w;
  const float root = radius * sqrt(max(dot(across, across) - r2 * (dot(x, x) * ww - xw * xw), 0));
  return (vec2(-root, root) + (cx * cw - r2 * xw)) / (cw * cw - r2 * ww);
}

ScreenBounds screen_bounds(RasterView view, vec3 center, float radius) {
  const mat4 m = view.clip_from_world, rows = transpose(m);
  const vec4 clip = m * vec4(center, 1);
  const vec4 error = 1e-6 * (abs(m[0] * center.x) + abs(m[1] * center.y) + abs(m[2] * center.z) + abs(m[3]));
  radius += 1e-6 * max(abs(center.x), max(abs(center.y), abs(center.z)));
  const vec3 w = rows[3].xyz;
  const float w_size = length(w), nearest_w = clip.w - radius * w_size - error.w;
  ScreenBounds bounds;
  bounds.known = nearest_w > 0.05 * clip.w;
  if (!bounds.known) return bounds;

  const vec2 across = touching_planes(rows[0].xyz, w, clip.x, clip.w, radius),
             down = touching_planes(rows[1].xyz, w, clip.y, clip.w, radius);
  const vec2 size = vec2(view.width, view.height);
  const vec2 low = vec2(across.x, down.x), high = vec2(across.y, down.y);
  const vec2 slack_ndc = (error.xy + error.w * max(vec2(1), max(abs(low), abs(high)))) / nearest_w;
  const float slack_pixels = 1.0 / kSubpixels;  // vertices are rounded by half of that
  bounds.low = (low - slack_ndc) * (0.5 * size) + 0.5 * size - slack_pixels;
  bounds.high = (high + slack_ndc) * (0.5 * size) + 0.5 * size + slack_pixels;

  const vec3 towards = w_size > 0 ? -w / w_size : rows[2].xyz / max(length(rows[2].xyz), 1e-30);
  const vec4 nearest = m * vec4(center + radius * towards, 1);
  bounds.nearest = (nearest.z + error.z) / (nearest.w - error.w) * (1 + 1e-5);
  return bounds;
}

// Small-primitive test: true if the bounds contain no sample.
bool misses_samples(ScreenBounds bounds) {
  if (any(greaterThan(bounds.high - bounds.low, vec2(1)))) return false;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    const vec2 at = vec2(kSamplePosition[s]) / kSubpixels;
    if (all(lessThanEqual(ceil(bounds.low - at), floor(bounds.high - at)))) return false;
  }
  return true;
}

// Occlusion test: true if the sphere is behind the HiZ pyramid wherever it may be visible.
bool is_hidden(ScreenBounds bounds, uint64_t farthest, ivec2 size) {
  const ivec2 low = clamp(ivec2(floor(bounds.low)), ivec2(0), size - 1),
              high = clamp(ivec2(floor(bounds.high)), ivec2(0), size - 1);
  for (int level = 0; level < kHizLevels; ++level) {
    const int shift = kHizShift + level;
    const ivec2 first = low >> shift, last = high >> shift;
    if (max(last.x - first.x, last.y - first.y) > 3) continue;  // use a coarser level
    const int start = first_of_level(size, level), row = blocks_of_level(size, level).x;
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        if (!(FloatsRef(farthest).at[start + y * row + x] > bounds.nearest)) return false;
      }
    }
    return true;
  }
  return false;
}

#endif
