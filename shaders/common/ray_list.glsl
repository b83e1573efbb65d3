// The list of pixels that need rays.
#ifndef FIRE3DV_RAY_LIST_GLSL
#define FIRE3DV_RAY_LIST_GLSL
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "common/buffers.glsl"

// All lanes call it; only entries that want rays are written.
void append(uint64_t list_address, uint64_t entries, RayEntry entry) {
  const bool wanted = entry.wanted != 0;
  const uvec4 ballot = subgroupBallot(wanted);
  const uint count = subgroupBallotBitCount(ballot);
  const uint rays = subgroupAdd(bitCount(entry.wanted));
  if (count == 0) return;
  uint base = 0;
  if (subgroupElect()) {
    RayListRef list = RayListRef(list_address);
    base = atomicAdd(list.value.width, count);
    atomicMax(list.value.groups_x, min((base + count + 63) / 64, 65535u));
    atomicMax(list.value.groups_y, ((base + count + 63) / 64 + 65534) / 65535);
    atomicAdd(list.value.rays, rays);
    list.value.groups_z = 1;
    list.value.height = 1;
    list.value.depth = 1;
  }
  base = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot);
  if (wanted) RayEntryRef(entries).at[base] = entry;
}

#endif
