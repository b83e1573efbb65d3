// Coverage merge: triangles of a pixel that continue each other become one shading sample. The triangle with
// most samples represents them in shading and shadow rays. With pixel-sized triangles most pixels show
// several of one surface. Only ids change. 4 samples only.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"
#include "common/push_of_group.glsl"
#include "common/visible_triangle.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { CoverageMergePush pushed; };
FIRE3DV_DEFINE_PUSH_OF_GROUP(CoverageMergePush, CoverageMergePushRef, globals, gl_WorkGroupID.z)

// Merge conditions: same part, nearly the same normal, and samples within half a pixel's width of the other
// plane. Large triangles are skipped, since few pixels show several.
const float kMinCosine = 0.9945;  // 6 degrees
const float kMaxPixels = 5;       // along each side of the image

vec3 world_normal(GlobalsRef globals, ClusterInstance instance, uint triangle) {
  const uint packed = UintRef(globals.value.cluster_triangles).at[instance.first_triangle + triangle];
  PositionRef positions = PositionRef(globals.value.positions);
  const vec3 a = positions.at[instance.first_vertex + (packed & 255)];
  const vec3 b = positions.at[instance.first_vertex + ((packed >> 8) & 255)];
  const vec3 c = positions.at[instance.first_vertex + ((packed >> 16) & 255)];
  return normal_direction(AffineRowsRef(globals.value.world_from_node).at[instance.node],
                          UintRef(globals.value.node_facts).at[instance.node], cross(b - a, c - a));
}

// Depth of the triangle's plane at an image position.
float plane_depth(VisibleTriangle t, vec2 position, vec2 size) {
  const vec3 b = barycentrics_at(t, position, size);
  const vec4 clip = t.clip[0] * b.x + t.clip[1] * b.y + t.clip[2] * b.z;
  return clip.z / clip.w;
}

bool is_small(VisibleTriangle t, vec2 size) {
  if (min(t.clip[0].w, min(t.clip[1].w, t.clip[2].w)) <= 0) return false;
  const vec2 a = t.clip[0].xy / t.clip[0].w, b = t.clip[1].xy / t.clip[1].w, c = t.clip[2].xy / t.clip[2].w;
  return all(lessThan((max(a, max(b, c)) - min(a, min(b, c))) * 0.5 * size, vec2(kMaxPixels)));
}

// Sample whose triangle has most open samples.
int leader_of(PixelIds ids, uint open) {
  int leader = 0, most = 0;
  for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
    if ((open & (1u << s)) == 0) continue;
    const int count = bitCount(open & samples_with(ids, id_of_sample(ids, s)));
    if (count > most) {
      most = count;
      leader = s;
    }
  }
  return leader;
}

void main() {
  push = push_of_group();
  GlobalsRef globals = GlobalsRef(push.globals);
  const uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= globals.value.width || pixel.y >= globals.value.height) return;
  const uint index = pixel.y * globals.value.width + pixel.x;
  PixelIds ids = pixel_ids(globals, push.visibility, index);
  uint open = kAllSamples & ~samples_with(ids, 0);
  // one triangle
  if (open == 0 || (open & ~samples_with(ids, id_of_sample(ids, findLSB(open)))) == 0) return;
  const vec4 depth = pixel_depths(globals, push.visibility, index);
  const vec2 size = vec2(globals.value.width, globals.value.height);
  while (bitCount(open) > 1) {
    const int leader = leader_of(ids, open);
    const uint id = id_of_sample(ids, leader), leader_part = part_of_id(globals, id);
    open &= ~samples_with(ids, id);
    VisibleTriangle triangle;
    vec3 normal;
    bool looked = false;
    uint left = open;
    while (left != 0) {
      const uint other = id_of_sample(ids, findLSB(left)), same = left & samples_with(ids, other);
      left &= ~same;
      const ClusterInstance instance = ClusterInstanceRef(globals.value.cluster_instances).at[(other >> 7) - 1];
      if (instance.part != leader_part) continue;
      if (!looked) {
        looked = true;
        triangle = visible_triangle(globals, id);
        if (!is_small(triangle, size)) break;
        normal = cross(triangle.world[1] - triangle.world[0], triangle.world[2] - triangle.world[0]);
        if ((triangle.node_facts & FIRE3DV_NODE_MIRRORED) != 0) normal = -normal;
      }
      const vec3 other_normal = world_normal(globals, instance, other & 127);
      if (!(dot(normal, other_normal) > kMinCosine * sqrt(dot(normal, normal) * dot(other_normal, other_normal)))) continue;
      for (int s = 0; s < FIRE3DV_SAMPLES; ++s) {
        if ((same & (1u << s)) == 0) continue;
        const vec2 position = vec2(pixel) + vec2(kSamplePosition[s]) / kSubpixels;
        const float reach = globals.value.half_pixel_depth.x * depth[s] + globals.value.half_pixel_depth.y;
        if (!(abs(plane_depth(triangle, position, size) - depth[s]) <= reach)) continue;
        open &= ~(1u << s);
        WordRef(push.visibility).at[2 * (index * FIRE3DV_SAMPLES + s)] = id;
      }
    }
  }
}
