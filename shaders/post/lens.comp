// Lens distortion by resampling of a larger pinhole image. Colours use bilinear filtering; planes of numbers
// use the nearest pixel. Depth is interpolated within one instance, by inverse depths, which are linear in
// the image of a plane.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "common/buffers.glsl"
#include "common/tone_map.glsl"
#include "sensor/content_mask.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { LensPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LensWantedRef { LensWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatRef { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer FloatOut { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2Ref { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec2Out { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PairRef { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PairOut { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer QuadRef { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer QuadOut { uvec4 at[]; };

#define kInfinity uintBitsToFloat(0x7f800000u)

// Same formulas as in renderer/passes/post/lens_pass.cpp, which names their sources. Radial term without p1 and p2:
// distorted radius and its derivative.
vec2 radial(LensWanted w, float r) {
  const vec4 k = w.coefficients;
  if (w.fisheye == 0) {
    const float r2 = r * r;
    return vec2(r * (1 + r2 * (k.x + r2 * (k.y + r2 * w.last_coefficient))),
                1 + r2 * (3 * k.x + r2 * (5 * k.y + r2 * 7 * w.last_coefficient)));
  }
  const float t = atan(r), t2 = t * t;
  return vec2(t * (1 + t2 * (k.x + t2 * (k.y + t2 * (k.z + t2 * k.w)))),
              (1 + t2 * (3 * k.x + t2 * (5 * k.y + t2 * (7 * k.z + t2 * 9 * k.w)))) / (1 + r * r));
}

vec2 distort(LensWanted w, vec2 p) {
  const float r = length(p);
  if (r == 0) return p;
  const vec2 moved = p * (radial(w, r).x / r);
  if (w.fisheye != 0) return moved;
  const float p1 = w.coefficients.z, p2 = w.coefficients.w, xy = 2 * p.x * p.y;
  return moved + vec2(p1 * xy + p2 * (r * r + 2 * p.x * p.x), p1 * (r * r + 2 * p.y * p.y) + p2 * xy);
}

// Jacobian of plumb_bob distortion; symmetric.
mat2 slope(LensWanted w, vec2 p) {
  const float r2 = dot(p, p), p1 = w.coefficients.z, p2 = w.coefficients.w;
  const float f = 1 + r2 * (w.coefficients.x + r2 * (w.coefficients.y + r2 * w.last_coefficient));
  const float g = w.coefficients.x + r2 * (2 * w.coefficients.y + r2 * 3 * w.last_coefficient);
  const float across = 2 * p.x * p.y * g + 2 * p1 * p.x + 2 * p2 * p.y;
  return mat2(f + 2 * p.x * p.x * g + 2 * p1 * p.y + 6 * p2 * p.x, across, across,
              f + 2 * p.y * p.y * g + 6 * p1 * p.y + 2 * p2 * p.x);
}

// Inverts the distortion; false where the lens shows nothing.
bool undistort(LensWanted w, vec2 distorted, out vec2 point) {
  const float d = length(distorted);
  float low = 0, high = w.largest_radius, r = min(d, high);
  for (int i = 0; i < 24; ++i) {
    const vec2 at = radial(w, r);
    if (at.x < d) low = r; else high = r;
    const float next = r - (at.x - d) / at.y;
    r = next > low && next < high ? next : 0.5 * (low + high);
  }
  point = d > 0 ? distorted * (r / d) : vec2(0);
  if (w.fisheye == 0) {
    for (int i = 0; i < 6; ++i) point -= inverse(slope(w, point)) * (distort(w, point) - distorted);
  }
  return length(distort(w, point) - distorted) < 1e-4 * max(1, d) && length(point) <= w.largest_radius;
}

vec3 decode_srgb(vec3 encoded) {
  return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

// Bilinear neighbours of a position: pixel indices and weights.
struct Around {
  uvec4 index;
  vec4 share;
  uint nearest;
};
Around around(LensWanted w, vec2 source) {
  const ivec2 last = ivec2(w.width_in, w.height_in) - 1;
  const ivec2 low = clamp(ivec2(floor(source)), ivec2(0), last), high = min(low + 1, last);
  const vec2 f = clamp(source - vec2(low), vec2(0), vec2(1));
  const uvec2 row = uvec2(low.y, high.y) * w.width_in;
  Around a;
  a.index = uvec4(row.x + low.x, row.x + high.x, row.y + low.x, row.y + high.x);
  a.share = vec4((1 - f.x) * (1 - f.y), f.x * (1 - f.y), (1 - f.x) * f.y, f.x * f.y);
  a.nearest = a.index[(f.x > 0.5 ? 1 : 0) + (f.y > 0.5 ? 2 : 0)];
  return a;
}

float depth_at(LensWanted w, Around a) {
  FloatRef depth = FloatRef(w.depth_in);
  const float nearest = depth.at[a.nearest];
  UintRef instance = UintRef(w.instance_in);
  float inverse_sum = 0;
  for (int i = 0; i < 4; ++i) {
    if (instance.at[a.index[i]] != instance.at[a.nearest]) return nearest;
    inverse_sum += a.share[i] / depth.at[a.index[i]];
  }
  return instance.at[a.nearest] == 0 ? kInfinity : 1 / inverse_sum;
}

// Motion in distorted pixels, from the previous image.
vec2 motion_at(LensWanted w, vec2 pixel, vec2 source, uint nearest) {
  const vec2 before_in = source - Vec2Ref(w.motion_in).at[nearest];
  const vec2 before = distort(w, (before_in - w.principal_point_in) / w.focal_in) * w.focal + w.principal_point;
  // Exactly zero for static surfaces.
  return before_in == source ? vec2(0) : pixel - before;
}

// Whether the previous image showed the place of a pixel's point within its borders and the lens's field.
bool was_inside(LensWanted w, vec2 source, uint nearest) {
  const vec2 before_in = source - Vec2Ref(w.motion_in).at[nearest];
  const vec2 point = (before_in - w.principal_point_in) / w.focal_in;
  if (!(length(point) <= w.largest_radius)) return false;
  const vec2 before = distort(w, point) * w.focal + w.principal_point;
  return all(greaterThanEqual(before, vec2(-0.5))) && all(lessThan(before, vec2(w.width, w.height) - 0.5));
}

uint occlusion_at(LensWanted w, vec2 source, uint nearest) {
  const uint value = UintRef(w.occlusion_in).at[nearest];
  const bool is_background = UintRef(w.instance_in).at[nearest] == 0;
  // A node that was hidden has no motion.
  const bool has_place = !isnan(Vec2Ref(w.motion_in).at[nearest].x);
  return is_background || !has_place || was_inside(w, source, nearest) ? value : FIRE3DV_OUTSIDE;
}

void main() {
  const LensWanted w = LensWantedRef(push.wanted).value;
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= w.width || pixel.y >= w.height) return;
  const uint index = pixel.y * w.width + pixel.x;
  vec2 point;
  const bool in_field = undistort(w, (vec2(pixel) - w.principal_point) / w.focal, point);
  const bool shown = in_field && is_in_mask(pixel, uvec2(w.width, w.height), w.mask_radius, w.mask_cut);
  const vec2 source = in_field ? point * w.focal_in + w.principal_point_in : vec2(0);
  const Around a = around(w, source);

  if (w.color_out != 0ul) {
    vec3 sum = vec3(0);
    for (int i = 0; i < 4; ++i) sum += a.share[i] * decode_srgb(unpackUnorm4x8(UintRef(w.color_in).at[a.index[i]]).rgb);
    WordRef(w.color_out).at[index] = packUnorm4x8(vec4(shown ? encode_srgb(sum) : vec3(0), 1));
  }
  if (w.linear_out != 0ul) {
    vec4 sum = vec4(0);
    for (int i = 0; i < 4; ++i) {
      const uvec2 halves = PairRef(w.linear_in).at[a.index[i]];
      sum += a.share[i] * vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
    }
    if (!shown) sum = vec4(0, 0, 0, 1);
    PairOut(w.linear_out).at[index] = pack_halves(sum.xyz, sum.w);
  }
  if (w.light_out != 0ul) {
    vec4 sum = vec4(0);
    for (int i = 0; i < 4; ++i) {
      const uvec2 halves = PairRef(w.light_in).at[a.index[i]];
      sum += a.share[i] * vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
    }
    PairOut(w.light_out).at[index] = in_field ? pack_halves(sum.xyz, round_to_halves(sum.www).x) : uvec2(0);
  }
  if (w.depth_out != 0ul) FloatOut(w.depth_out).at[index] = shown ? depth_at(w, a) : kInfinity;
  if (w.instance_out != 0ul) WordRef(w.instance_out).at[index] = shown ? UintRef(w.instance_in).at[a.nearest] : 0;
  if (w.semantic_out != 0ul) WordRef(w.semantic_out).at[index] = shown ? UintRef(w.semantic_in).at[a.nearest] : 0;
  if (w.normal_out != 0ul) PairOut(w.normal_out).at[index] = shown ? PairRef(w.normal_in).at[a.nearest] : uvec2(0);
  if (w.motion_out != 0ul)
    Vec2Out(w.motion_out).at[index] = shown ? motion_at(w, vec2(pixel), source, a.nearest) : vec2(0);
  if (w.albedo_out != 0ul) PairOut(w.albedo_out).at[index] = shown ? PairRef(w.albedo_in).at[a.nearest] : uvec2(0);
  if (w.roughness_out != 0ul) FloatOut(w.roughness_out).at[index] = shown ? FloatRef(w.roughness_in).at[a.nearest] : 0;
  if (w.metallic_out != 0ul) FloatOut(w.metallic_out).at[index] = shown ? FloatRef(w.metallic_in).at[a.nearest] : 0;
  if (w.position_out != 0ul) QuadOut(w.position_out).at[index] = shown ? QuadRef(w.position_in).at[a.nearest] : uvec4(0);
  if (w.occlusion_out != 0ul) WordRef(w.occlusion_out).at[index] = shown ? occlusion_at(w, source, a.nearest) : FIRE3DV_SEEN;
}
