// The lists of what rays have to tell.
#ifndef FIRE3DV_RAY_LIST_GLSL
#define FIRE3DV_RAY_LIST_GLSL
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "common/buffers.glsl"

// The dispatch is as large as a list of so many needs.
void widen(RayListRef lists, uint list, uint count) {
  const uint groups = (count + 63) / 64;
  atomicMax(lists.at[list].groups_x, min(groups, 65535u));
  if (groups > 65535) atomicMax(lists.at[list].groups_y, (groups + 65534) / 65535);
}

// All lanes call it.
void count_rays(uint64_t lists, uint rays) {
  const uint sum = subgroupAdd(rays);
  if (sum != 0 && subgroupElect()) atomicAdd(RayListRef(lists).at[FIRE3DV_LIST_PIXELS].rays, sum);
}

// All lanes call it; only entries that want rays are written.
void append(uint64_t lists, uint64_t entries, RayEntry entry) {
  const bool wanted = entry.wanted != 0;
  const uvec4 ballot = subgroupBallot(wanted);
  const uint count = subgroupBallotBitCount(ballot);
  if (count == 0) return;
  uint base = 0;
  if (subgroupElect()) {
    base = atomicAdd(RayListRef(lists).at[FIRE3DV_LIST_PIXELS].width, count);
    // Whoever begins a group says so.
    if ((base + count + 63) / 64 != (base + 63) / 64) widen(RayListRef(lists), FIRE3DV_LIST_PIXELS, base + count);
  }
  base = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(ballot);
  if (wanted) RayEntryRef(entries).at[base] = entry;
}

// Where not all can be written, all of the image's pixels are `left`: their entries tell of all rays, too. Lane by lane,
// since drivers gather that better than it could be done here, between a light and the next.
void append(uint64_t lists_address, uint64_t found, uint room, uint pixels, FoundRay ray) {
  RayListRef lists = RayListRef(lists_address);
  const uint place = atomicAdd(lists.at[FIRE3DV_LIST_FOUND].width, 1);
  if (place < room) {
    FoundRayRef(found).at[place] = ray;
  } else if (place == room) {
    atomicMax(lists.at[FIRE3DV_LIST_LEFT].width, pixels);
    widen(lists, FIRE3DV_LIST_LEFT, pixels);
  }
}

#endif
