// What of each pixel's shadows is known without a ray; the rest goes on the list. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "common/culling.glsl"
#include "common/shadow_maps.glsl"
#include "common/shadow_points.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ShadowPush push; };

void append(bool wanted, RayEntry entry) {
  const uvec4 ballot = subgroupBallot(wanted);
  const uint count = subgroupBallotBitCount(ballot);
  const uint rays = subgroupAdd(wanted ? bitCount(entry.wanted) : 0);
  if (count == 0) return;
  uint base = 0;
  if (subgroupElect()) {
    RayListRef list = RayListRef(push.list);
    base = atomicAdd(list.value.width, count);
    atomicMax(list.value.groups_x, min((base + count + 63) / 64, 65535u));
    atomicMax(list.value.groups_y, ((base + count + 63) / 64 + 65534) / 65535);
    atomicAdd(list.value.rays, rays);
    list.value.groups_z = 1;
    list.value.height = 1;
    list.value.depth = 1;
  }
  base = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot);
  if (wanted) RayEntryRef(push.entries).at[base] = entry;
}

// Of a body that is seen from outside: a ray from a side that is turned away from the light starts inside of it.
bool is_body(GlobalsRef globals, VisibleTriangle triangle) {
  const PrimitiveRecord primitive = PrimitiveRef(globals.value.primitives).at[triangle.part.primitive];
  return casts_by_far_sides(globals, triangle.part, primitive, triangle.world_from_node);
}

bool is_turned_away(SurfacePoint point, LightSample light) {
  return dot(point.plane_normal_world, light.to_light) < -0.02 - light.sine;
}

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const bool inside = gl_GlobalInvocationID.x < globals.value.width && gl_GlobalInvocationID.y < globals.value.height;
  RayEntry entry;
  entry.pixel = gl_GlobalInvocationID.y * globals.value.width + gl_GlobalInvocationID.x;
  entry.word = gl_GlobalInvocationID.z;
  entry.wanted = 0;
  if (inside) {
    uint known = FIRE3DV_NO_INDEX;  // all lit
    const PixelIds ids = pixel_ids(push.visibility, entry.pixel);
    uint open = kAllSamples & ~samples_with(ids, 0);
    while (open != 0) {
      const int s = findLSB(open);
      const uint id = id_of_sample(ids, s), same = samples_with(ids, id);
      open &= ~same;
      const VisibleTriangle triangle = visible_triangle(globals, id);
      const SurfacePoint point = surface_point(globals, triangle, place_of_samples(gl_GlobalInvocationID.xy, same));
      const bool body = push.hybrid != 0 && is_body(globals, triangle);
      if ((MaterialRef(globals.value.materials).at[point.material].flags & FIRE3DV_MATERIAL_UNLIT) != 0) continue;
      for (uint i = 0; i < globals.value.light_count; ++i) {
        const LightShadow shadow = LightShadowRef(globals.value.light_shadows).at[i];
        if (shadow.mask_word != entry.word) continue;
        const LightRecord record = LightRef(globals.value.lights).at[i];
        const LightSample light =
            sample_light(record, AffineRowsRef(globals.value.world_from_node).at[record.node], point.position_world);
        if (!light_matters(globals, point, light)) continue;
        uint verdict = kUnknown;
        if (body && is_turned_away(point, light)) {
          verdict = kShadowed;
        } else if (push.hybrid != 0 && shadow.rays == 1) {
          const ShadowRay ray = shadow_ray(globals, point, record, light);
          verdict = map_verdict(globals, shadow, part_of_id(globals, id), ray.origin, point.plane_normal_world, ray.light);
        }
        if (verdict == kLit) continue;
        if (shadow.rays == 1) {
          known &= ~(same << shadow.mask_shift);
          if (verdict == kUnknown) entry.wanted |= 1u << (shadow.mask_shift + s);
        } else {
          known &= ~(255u << (8 * s));
          entry.wanted |= 1u << s;
        }
      }
    }
    UintsRef(globals.value.shadow_mask).at[entry.pixel * globals.value.mask_words + entry.word] = known;
  }
  append(entry.wanted != 0, entry);
}
