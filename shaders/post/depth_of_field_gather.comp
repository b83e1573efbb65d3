// Second step of depth of field: each pixel gathers the light of those whose circles of confusion reach it (scatter as
// gather: Jimenez 2014; Abadie 2018). Surfaces before that of the pixel lie over it, those behind show where they
// are not covered. Pixels that stay sharp are not written. Variants: FIRE3DV_MULTISAMPLED.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/halves.glsl"
#include "post/depth_of_field.glsl"

layout(local_size_x = FIRE3DV_BLUR_TILE, local_size_y = FIRE3DV_BLUR_TILE) in;
layout(push_constant, scalar) uniform Push { DepthOfFieldPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }
#ifdef FIRE3DV_MULTISAMPLED
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform writeonly image2DMS hdr;
#else
layout(set = 0, binding = FIRE3DV_BINDING_FILTER_OUT, rgba16f) uniform writeonly image2D hdr;
#endif

const int kReach = (FIRE3DV_MAX_BLUR_RADIUS + FIRE3DV_BLUR_TILE - 1) / FIRE3DV_BLUR_TILE;  // tiles
const uint kLanes = FIRE3DV_BLUR_TILE * FIRE3DV_BLUR_TILE;
// Weight of surfaces behind one that hides them, where no circle reaches; far below that of circles.
const float kGuess = 1e-5;

shared uint reaching_radius;  // bits of a float

// Largest radius of the near layer among tiles from which it reaches this one.
void find_reaching_radius() {
  const ivec2 tiles = ivec2(gl_NumWorkGroups.xy);
  for (uint i = gl_LocalInvocationIndex; i < (2 * kReach + 1) * (2 * kReach + 1); i += kLanes) {
    const ivec2 away = ivec2(i % (2 * kReach + 1), i / (2 * kReach + 1)) - kReach;
    const ivec2 tile = ivec2(gl_WorkGroupID.xy) + away;
    if (any(lessThan(tile, ivec2(0))) || any(greaterThanEqual(tile, tiles))) continue;
    const uint radius = BlurTileRef(push.tiles).at[tile.y * tiles.x + tile.x].near_radius;
    const vec2 gap = vec2(max((abs(away) - 1) * FIRE3DV_BLUR_TILE + 1, 0));
    if (uintBitsToFloat(radius) + 0.5 >= length(gap)) atomicMax(reaching_radius, radius);
  }
}

// Share of a pixel at this distance that a circle covers.
float covered(float radius, float distance_px) { return clamp(radius - distance_px + 0.5, 0, 1); }

// Sum of covered() over all pixels; of square pixels exact below a radius of 2.5, else within 1 %.
float covered_pixels(float radius) {
  const float stretched = push.stretch.x * push.stretch.y;
  if (radius >= 2.5) return max(3.14159265 * (radius * radius + 1.0 / 12) / stretched, 1);
  const float square =
      1 + 4 * (covered(radius, 1) + covered(radius, 1.41421356) + covered(radius, 2) + covered(radius, 2.82842712)) +
      8 * covered(radius, 2.23606798);
  return max(square / stretched, 1);
}

// Light and its weight; scene: scene-referred part of the weight.
struct Sum {
  vec3 light;
  float weight, scene;
};

Sum scaled(Sum sum, float factor) { return Sum(factor * sum.light, factor * sum.weight, factor * sum.scene); }

void add(inout Sum sum, float factor, uint packed_light[2], float scene_referred) {
  const vec2 last = unpackHalf2x16(packed_light[1]);
  sum.light += factor * vec3(unpackHalf2x16(packed_light[0]), last.x);
  sum.weight += factor * last.y;
  sum.scene += factor * scene_referred;
}

float share_of(uint packed_light[2]) { return unpackHalf2x16(packed_light[1]).y; }

Sum over(Sum front, Sum behind) {
  const float open = max(1 - front.weight, 0);
  return Sum(front.light + open * behind.light, front.weight + open * behind.weight, front.scene + open * behind.scene);
}

void write(ivec2 pixel, vec4 color) {
#ifdef FIRE3DV_MULTISAMPLED
  for (int i = 0; i < push.samples; ++i) imageStore(hdr, pixel, i, color);
#else
  imageStore(hdr, pixel, color);
#endif
}

void gather(ivec2 pixel) {
  const BlurTexel here = BlurTexelRef(push.texels).at[pixel.y * push.width + pixel.x];
  const vec2 radii = unpackHalf2x16(here.radii);
  const bool has_near = share_of(here.near_light) > 0, has_far = share_of(here.far_light) > 0;
  const float near_radius = radii.x, far_radius = radii.y;
  const float reaching = uintBitsToFloat(reaching_radius);
  const float window = max(reaching, has_far ? far_radius : 0);
  if (window <= kSharpRadius) return;
  const int reach = int(ceil(window + 0.5));
  // Before the pixel's surface of the near layer, that surface, before its surface of the far layer, and the rest.
  Sum front = Sum(vec3(0), 0, 0), own = front, behind = front, hidden = front;
  bool is_sharp = !has_far && near_radius <= kSharpRadius;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      const float distance_px = length(push.stretch * vec2(x, y));
      if (distance_px > window + 0.5) continue;
      const ivec2 from = clamp(pixel + ivec2(x, y), ivec2(0), ivec2(push.width, push.height) - 1);
      const BlurTexel texel = BlurTexelRef(push.texels).at[from.y * push.width + from.x];
      const vec2 texel_radii = unpackHalf2x16(texel.radii);
      const vec2 scene_referred = unpackHalf2x16(texel.scene_referred);
      const float guess = kGuess / (1 + distance_px * distance_px * distance_px * distance_px);
      if (share_of(texel.near_light) > 0) {
        const float weight = covered(texel_radii.x, distance_px) / covered_pixels(texel_radii.x);
        const float nearer = texel_radii.x - near_radius;
        const float is_front = has_near ? clamp(2 * nearer - 1, 0, 1) : 1;
        const float is_behind = has_near ? clamp(-2 * nearer - 1, 0, 1) : 0;
        add(front, weight * is_front, texel.near_light, scene_referred.x);
        add(own, weight * (1 - is_front - is_behind), texel.near_light, scene_referred.x);
        add(hidden, (weight + guess) * is_behind, texel.near_light, scene_referred.x);
        if (weight > 0 && distance_px > 0) is_sharp = false;
      }
      if (share_of(texel.far_light) > 0) {
        // The cone of rays ends at the pixel's own surface: it is no wider than there.
        const float radius = has_far ? min(texel_radii.y, far_radius) : texel_radii.y;
        const float weight = covered(radius, distance_px) / covered_pixels(radius) + (has_far ? 0 : guess);
        const float is_front = has_far ? clamp(2 * (far_radius - texel_radii.y) - 1, 0, 1) : 0;
        add(behind, weight * is_front, texel.far_light, scene_referred.y);
        add(hidden, weight * (1 - is_front), texel.far_light, scene_referred.y);
      }
    }
  }
  if (is_sharp) return;
  if (front.weight > 1) front = scaled(front, 1 / front.weight);
  // The pixel's own surface is as opaque as the share that surfaces before it leave open.
  const float open = max(1 - front.weight, 1e-4);
  if (own.weight > 0) own = scaled(own, min(1 / own.weight, 1 / open));
  if (behind.weight > 1) behind = scaled(behind, 1 / behind.weight);
  if (hidden.weight > 0) hidden = scaled(hidden, 1 / hidden.weight);
  Sum sum = over(front, over(own, over(behind, hidden)));
  if (!(sum.weight > 0)) return;
  sum = scaled(sum, 1 / sum.weight);
  write(pixel, vec4(round_to_halves(sum.light), clamp(sum.scene, 0, 1)));
}

void main() {
  if (gl_LocalInvocationIndex == 0) reaching_radius = 0;
  barrier();
  find_reaching_radius();
  barrier();
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x < push.width && pixel.y < push.height && !is_ended()) gather(pixel);
}
