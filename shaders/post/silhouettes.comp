// Silhouettes of instances, each as if it were drawn alone: one bit per instance and pixel. Or blended surfaces,
// drawn into a copy of the visibility buffer for labels. One cluster per workgroup, with the coverage rules of the
// visibility buffer. Variants: FIRE3DV_SAMPLES 1 or 4, of the visibility buffer; silhouettes have one sample, the
// pixel's centre.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "visibility/camera_raster.glsl"
#include "visibility/clip_polygon.glsl"

const uint kThreads = 64;
const int kMaxPixelsByOne = 64;  // of a box that one thread fills
layout(local_size_x = kThreads) in;
layout(push_constant, scalar) uniform Push { SilhouettesPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer SilhouettesWantedRef { SilhouettesWanted value; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LabelPartRef { LabelPart at[]; };

// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended(SilhouettesWanted wanted) { return ImageGlobals(wanted.globals).ends_early != 0ul; }

const ivec2 kCenter = ivec2(kHalfPixel);

// What the workgroup draws.
struct Target {
  GlobalsRef globals;
  SilhouettesWanted wanted;
  LabelPart part;
  ivec2 size;
};

bool is_drawn_at(Target target, VisibleTriangle t, vec2 position) {
  const float limit = target.part.alpha_limit;
  if (limit == 0) return true;
  const vec2 size = vec2(target.size);
  const vec3 b = inside(barycentrics_at(t, position, size));
  vec3 b_dx, b_dy;
  barycentric_changes(t, position, size, b_dx, b_dy);
  const MaterialRecord material = MaterialRef(target.globals.value.materials).at[t.material];
  const TriangleUv uv = triangle_uv(target.globals, t, material.flags);
  const float alpha = material.base_color.a * color_at(target.globals, t, b).a *
                      sample_or(material.base_color_texture, uv_at(uv, b), uv_at(uv, b_dx), uv_at(uv, b_dy), vec4(1)).a;
  return alpha >= (limit == FIRE3DV_ALPHA_CUTOFF ? material.alpha_cutoff : limit);
}

// Edge functions of a position, and its depth; all at least the bias: covered.
bool covers(ivec2 position, ScreenVertex a, ScreenVertex b, ScreenVertex c, float inverse_area, out float depth) {
  const ivec2 ab = b.xy - a.xy, bc = c.xy - b.xy, ca = a.xy - c.xy;
  const i64vec2 from_a = i64vec2(position - a.xy), from_b = i64vec2(position - b.xy), from_c = i64vec2(position - c.xy);
  const int64_t wa = int64_t(bc.x) * from_b.y - int64_t(bc.y) * from_b.x;
  const int64_t wb = int64_t(ca.x) * from_c.y - int64_t(ca.y) * from_c.x;
  const int64_t wc = int64_t(ab.x) * from_a.y - int64_t(ab.y) * from_a.x;
  precise const float z = (float(wa) * a.z + float(wb) * b.z + float(wc) * c.z) * inverse_area;
  depth = z;
  return wa >= edge_bias(b.xy, c.xy) && wb >= edge_bias(c.xy, a.xy) && wc >= edge_bias(a.xy, b.xy);
}

void draw_silhouette(Target target, VisibleTriangle t, ivec2 pixel, ScreenVertex a, ScreenVertex b, ScreenVertex c, float inverse_area) {
  float depth;
  if (!covers(pixel * kSubpixels + kCenter, a, b, c, inverse_area, depth) || depth < 0) return;
  const uint slot = target.part.slot, bit = 1u << (slot & 31u);
  const uint word = (slot >> 5) * uint(target.size.x * target.size.y) + uint(pixel.y * target.size.x + pixel.x);
  UintsRef bits = UintsRef(target.wanted.bits);
  if ((bits.at[word] & bit) != 0 || !is_drawn_at(target, t, vec2(pixel) + 0.5)) return;
  atomicOr(bits.at[word], bit);
}

void draw_label(Target target, VisibleTriangle t, uint id, ivec2 pixel, ScreenVertex a, ScreenVertex b, ScreenVertex c, float inverse_area) {
  uint covered = 0;
  float depth[FIRE3DV_SAMPLES];
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s)
    if (covers(pixel * kSubpixels + kSamplePosition[s], a, b, c, inverse_area, depth[s]) && depth[s] >= 0) covered |= 1u << s;
  if (covered == 0 || !is_drawn_at(target, t, tested_position(pixel, covered))) return;
  const uint first = uint(pixel.y * target.size.x + pixel.x) * FIRE3DV_SAMPLES;
  VisibilityRef visibility = VisibilityRef(target.wanted.visibility);
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s)
    if ((covered & (1u << s)) != 0)
      atomicMax(visibility.at[first + s], seen_value(depth[s], id, target.globals.value.visibility_generation));
}

bool shows_side(VisibleTriangle t, int64_t area) {
  const bool mirrored = (t.node_facts & FIRE3DV_NODE_MIRRORED) != 0;
  return area != 0 && ((t.part.flags & FIRE3DV_PART_DOUBLE_SIDED) != 0 || (area > 0) == mirrored);
}

int64_t area_of(ScreenVertex a, ScreenVertex b, ScreenVertex c) {
  const ivec2 ab = b.xy - a.xy, ac = c.xy - a.xy;
  return int64_t(ab.x) * ac.y - int64_t(ab.y) * ac.x;
}

void set_truncated(Target target) {
  if (target.wanted.bits != 0ul) atomicOr(UintsRef(target.wanted.truncated).at[target.part.slot >> 5], 1u << (target.part.slot & 31u));
}

void pixels_of(Target target, ScreenVertex a, ScreenVertex b, ScreenVertex c, out ivec2 low, out ivec2 high) {
  covered_pixels(min(a.xy, min(b.xy, c.xy)), max(a.xy, max(b.xy, c.xy)), 0, target.size, low, high);
  // The centre of a pixel may be covered where no sample is.
  low = max(low - 1, ivec2(0));
  high = min(high + 1, target.size - 1);
}

// Fills every `lanes`th pixel of the triangle's box, from the pixel `lane` on.
void fill(Target target, VisibleTriangle t, uint id, ScreenVertex a, ScreenVertex b, ScreenVertex c, uint lane, uint lanes) {
  int64_t area = area_of(a, b, c);
  if (!shows_side(t, area)) return;
  const ivec2 end = target.size * kSubpixels, least = min(a.xy, min(b.xy, c.xy)), most = max(a.xy, max(b.xy, c.xy));
  if (lane == 0 && (any(lessThan(least, ivec2(0))) || any(greaterThan(most, end)))) set_truncated(target);
  if (area < 0) {
    const ScreenVertex swapped = b;
    b = c;
    c = swapped;
    area = -area;
  }
  precise const float inverse_area = 1 / float(area);
  ivec2 low, high;
  pixels_of(target, a, b, c, low, high);
  if (low.x > high.x || low.y > high.y) return;
  const uint across = uint(high.x - low.x + 1), count = across * uint(high.y - low.y + 1);
  for (uint p = lane; p < count; p += lanes) {
    const ivec2 pixel = low + ivec2(p % across, p / across);
    if (target.wanted.bits != 0ul) {
      draw_silhouette(target, t, pixel, a, b, c, inverse_area);
    } else {
      draw_label(target, t, id, pixel, a, b, c, inverse_area);
    }
  }
}

shared uint large[128];
shared uint large_count;

// Draws a triangle that one thread can fill; false: it is large, or needs clipping.
bool draw_small(Target target, VisibleTriangle t, uint id) {
  const vec2 size = vec2(target.size);
  for (int i = 0; i < 3; ++i)
    if (!can_be_projected(t.clip[i], size)) return false;
  const ScreenVertex a = project(t.clip[0], size), b = project(t.clip[1], size), c = project(t.clip[2], size);
  ivec2 low, high;
  pixels_of(target, a, b, c, low, high);
  const ivec2 box = max(high - low + 1, ivec2(0));
  if (box.x * box.y > kMaxPixelsByOne) return false;
  fill(target, t, id, a, b, c, 0, 1);
  return true;
}

// All threads draw a large triangle.
void draw_large(Target target, VisibleTriangle t, uint id) {
  const vec2 size = vec2(target.size);
  vec4 corners[kMaxClipVertices];
  int count = 3;
  bool whole = true;
  for (int i = 0; i < 3; ++i) {
    corners[i] = t.clip[i];
    whole = whole && can_be_projected(corners[i], size);
  }
  if (!whole) {
    cut_to_view(corners, count, size);
    if (gl_LocalInvocationIndex == 0) set_truncated(target);
  }
  if (count < 3) return;
  const ScreenVertex a = project(corners[0], size);
  for (int i = 2; i < count; ++i)
    fill(target, t, id, a, project(corners[i - 1], size), project(corners[i], size), gl_LocalInvocationIndex, kThreads);
}

void main() {
  const SilhouettesWanted wanted = SilhouettesWantedRef(push.wanted).value;
  const uint cluster = gl_WorkGroupID.x + gl_WorkGroupID.y * 65535;
  if (cluster >= wanted.cluster_count) return;  // the whole group
  GlobalsRef globals = GlobalsRef(wanted.globals);
  const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[cluster];
  const LabelPart part = LabelPartRef(wanted.parts).at[instance.part];
  if (wanted.bits != 0ul ? part.slot == FIRE3DV_NO_INDEX : part.is_overlaid == 0) return;  // the whole group
  Target target = Target(globals, wanted, part, ivec2(globals.value.width, globals.value.height));
  const uint triangle_count = is_ended(wanted) ? 0 : instance.counts >> 16, first_id = (cluster + 1) << 7;
  if (gl_LocalInvocationIndex == 0) large_count = 0;
  barrier();
  for (uint number = gl_LocalInvocationIndex; number < triangle_count; number += kThreads) {
    if (!draw_small(target, visible_triangle(globals, first_id + number), first_id + number)) large[atomicAdd(large_count, 1)] = number;
  }
  barrier();
  for (uint i = 0; i < large_count; ++i) draw_large(target, visible_triangle(globals, first_id + large[i]), first_id + large[i]);
}
