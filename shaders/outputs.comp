// Writes what pixels show as planes of numbers: depth, labels, normals and motion, all of one surface for each pixel.
//
// That is the surface in the pixel's middle. Of four samples none lies there: what most of them show is taken, where a
// surface is all that one part shows; of equally many the nearest of which a triangle covers the middle, else the background,
// else the first. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"
#include "common/visible_triangle.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { OutputsPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer OutputsWantedRef { OutputsWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PartLabelsRef { PartLabels at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer FloatOut { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec2Out { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer HalfsOut { uvec2 at[]; };

#define kInfinity uintBitsToFloat(0x7f800000u)
#define kNotANumber uintBitsToFloat(0x7fc00000u)

// What a pixel shows.
struct Shown {
  uint id;  // 0: background
  vec2 place;
  float depth_m;  // along the look
};

vec3 ray_through(GlobalsRef globals, vec2 place) {
  const vec2 ndc = place / vec2(globals.value.width, globals.value.height) * 2 - 1;
  return globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y +
         globals.value.world_from_ndc_origin;
}

// Where the line of sight meets the triangle's plane, but never nearer or farther than the triangle itself: its corners lie
// on a grid for covering pixels, so that a pixel on the edge of one seen from the side may look a little past it.
float depth_at(GlobalsRef globals, OutputsWanted wanted, VisibleTriangle t, vec2 place) {
  const vec3 a = t.world[0] - globals.value.eye_world, b = t.world[1] - globals.value.eye_world,
             c = t.world[2] - globals.value.eye_world;
  const vec3 depths = vec3(dot(a, wanted.look_world), dot(b, wanted.look_world), dot(c, wanted.look_world));
  const float nearest = min(depths.x, min(depths.y, depths.z)), farthest = max(depths.x, max(depths.y, depths.z));
  float depth_m;
  if (wanted.orthographic != 0) {
    depth_m = dot(depths, barycentrics_at(t, place, vec2(globals.value.width, globals.value.height)));
  } else {
    // From the nearest corner: of a floor that reaches to the horizon the others are known less exactly.
    const vec3 corner = depths.x == nearest ? a : depths.y == nearest ? b : c;
    const vec3 normal = cross(b - a, c - a);
    depth_m = dot(normal, corner) / dot(normal, ray_through(globals, place));
  }
  if (isnan(depth_m) || isinf(depth_m)) depth_m = nearest > 0 ? nearest : farthest;
  return clamp(depth_m, nearest, farthest);
}

#if FIRE3DV_SAMPLES == 4
// Of the parts of the samples: those that most samples show, as bits of samples.
uint most_of(uvec4 parts) {
  uint most = 0;
  int most_count = 0;
  for (int s = 0; s < 4; ++s) {
    const int count = bitCount(samples_with(parts, parts[s]));
    if (count < most_count) continue;
    most = count > most_count ? 1u << s : most | (1u << s);
    most_count = count;
  }
  return most;
}

// Where no triangle of its covers the pixel's middle a part is looked at in the middle of its samples: that is the pixel's,
// if it has all. In the image depths of a plane are even by their inverses.
Shown shown_by_samples(GlobalsRef globals, OutputsWanted wanted, uvec2 pixel, PixelIds ids, uint samples) {
  float sum = 0;
  for (int s = 0; s < 4; ++s) {
    if ((samples & (1u << s)) == 0) continue;
    const vec2 place = vec2(pixel) + vec2(kSamplePosition[s]) / kSubpixels;
    const float depth_m = depth_at(globals, wanted, visible_triangle(globals, id_of_sample(ids, s)), place);
    sum += wanted.orthographic != 0 ? depth_m : 1 / depth_m;
  }
  const float mean = sum / bitCount(samples);
  return Shown(id_of_sample(ids, findLSB(samples)), place_of_samples(pixel, samples),
               wanted.orthographic != 0 ? mean : 1 / mean);
}

Shown shown_by_most(GlobalsRef globals, OutputsWanted wanted, uvec2 pixel, PixelIds ids) {
  const vec2 middle = vec2(pixel) + 0.5, size = vec2(globals.value.width, globals.value.height);
  uvec4 parts = uvec4(FIRE3DV_NO_INDEX);
  for (int s = 0; s < 4; ++s) {
    if (id_of_sample(ids, s) != 0) parts[s] = part_of_id(globals, id_of_sample(ids, s));
  }
  const uint candidates = most_of(parts);
  Shown shown = Shown(0, middle, kInfinity);
  uint open = candidates;
  while (open != 0) {
    const uint id = id_of_sample(ids, findLSB(open));
    open &= ~samples_with(ids, id);
    if (id == 0) continue;
    const VisibleTriangle t = visible_triangle(globals, id);
    const vec3 b = barycentrics_at(t, middle, size);
    if (min(b.x, min(b.y, b.z)) < 0) continue;
    const float depth_m = depth_at(globals, wanted, t, middle);
    if (depth_m < shown.depth_m) shown = Shown(id, middle, depth_m);
  }
  const bool has_background = (candidates & samples_with(parts, FIRE3DV_NO_INDEX)) != 0;
  if (shown.id != 0 || has_background) return shown;
  return shown_by_samples(globals, wanted, pixel, ids, samples_with(parts, parts[findLSB(candidates)]));
}
#endif

Shown shown_in(GlobalsRef globals, OutputsWanted wanted, uvec2 pixel) {
  const vec2 middle = vec2(pixel) + 0.5;
  const PixelIds ids = pixel_ids(push.visibility, pixel.y * globals.value.width + pixel.x);
  const uint id = id_of_sample(ids, 0);
#if FIRE3DV_SAMPLES == 4
  if (samples_with(ids, id) != kAllSamples) return shown_by_most(globals, wanted, pixel, ids);
#endif
  if (id == 0) return Shown(0, middle, kInfinity);
  return Shown(id, middle, depth_at(globals, wanted, visible_triangle(globals, id), middle));
}

vec3 normal_of(GlobalsRef globals, Shown shown) {
  return surface_point(globals, visible_triangle(globals, shown.id), shown.place).normal_world;
}

vec2 pixels_of(GlobalsRef globals, vec4 clip) {
  precise const vec2 pixels = (clip.xy / clip.w * 0.5 + 0.5) * vec2(globals.value.width, globals.value.height);
  return pixels;
}

vec4 clip_direction(mat4 clip_from_world, vec3 direction) {
  precise const vec4 clip = clip_from_world * vec4(direction, 0);
  return clip;
}

// How far what is shown has come, in the image, since the camera's last one. Both places are computed in the same way: what
// rests has come no way at all.
vec2 motion_of(GlobalsRef globals, OutputsWanted wanted, Shown shown) {
  if (wanted.last_world_from_node == 0ul) return vec2(0);
  vec4 here, there;
  if (shown.id == 0) {
    if (wanted.orthographic != 0) return vec2(0);
    const vec3 direction = ray_through(globals, shown.place);
    here = clip_direction(globals.value.clip_from_world, direction);
    there = clip_direction(wanted.last_clip_from_world, direction);
  } else {
    const VisibleTriangle t = visible_triangle(globals, shown.id);
    const vec3 b = nearby(barycentrics_at(t, shown.place, vec2(globals.value.width, globals.value.height)));
    PositionRef positions = PositionRef(globals.value.positions);
    const vec3 node = positions.at[t.vertex[0]] * b.x + positions.at[t.vertex[1]] * b.y + positions.at[t.vertex[2]] * b.z;
    here = clip_position(globals.value.clip_from_world, world_position(t.world_from_node, node));
    const AffineRows last = AffineRowsRef(wanted.last_world_from_node).at[t.part.node];
    there = clip_position(wanted.last_clip_from_world, world_position(last, node));
  }
  if (there.w <= 0) return vec2(kNotANumber);  // it was behind the eye
  return pixels_of(globals, here) - pixels_of(globals, there);
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  const uint index = pixel.y * globals.value.width + pixel.x;
  const OutputsWanted wanted = OutputsWantedRef(push.wanted).value;
  const Shown shown = shown_in(globals, wanted, pixel);
  if (wanted.depth != 0ul) FloatOut(wanted.depth).at[index] = shown.depth_m;
  if ((wanted.instance | wanted.semantic) != 0ul) {
    PartLabels labels = PartLabels(0, 0);
    if (shown.id != 0) labels = PartLabelsRef(wanted.labels).at[part_of_id(globals, shown.id)];
    if (wanted.instance != 0ul) WordRef(wanted.instance).at[index] = labels.instance;
    if (wanted.semantic != 0ul) WordRef(wanted.semantic).at[index] = labels.semantic;
  }
  if (wanted.normal != 0ul) {
    const vec3 normal = shown.id != 0 ? normal_of(globals, shown) : vec3(0);
    HalfsOut(wanted.normal).at[index] = uvec2(packHalf2x16(normal.xy), packHalf2x16(vec2(normal.z, 0)));
  }
  if (wanted.motion != 0ul) Vec2Out(wanted.motion).at[index] = motion_of(globals, wanted, shown);
}
