// Append operations of the shadow ray lists.
#ifndef FIRE3DV_RAY_LIST_GLSL
#define FIRE3DV_RAY_LIST_GLSL
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "common/buffers.glsl"

// Grows the indirect dispatch to cover `count` entries.
void widen(RayListRef lists, uint list, uint count) {
  const uint groups = (count + 63) / 64;
  atomicMax(lists.at[list].groups_x, min(groups, 65535u));
  if (groups > 65535) atomicMax(lists.at[list].groups_y, (groups + 65534) / 65535);
}

// All lanes must call it.
void count_rays(uint64_t lists, uint rays) {
  const uint sum = subgroupAdd(rays);
  if (sum != 0 && subgroupElect()) atomicAdd(RayListRef(lists).at[FIRE3DV_LIST_PIXELS].rays, sum);
}

// Index of this lane's new entry. GPU drivers aggregate the atomics of a subgroup; CPU drivers do not.
uint next_index(RayListRef lists, uint list) {
#ifdef FIRE3DV_CPU
  const uvec4 here = subgroupBallot(true);
  uint first = 0;
  if (subgroupElect()) first = atomicAdd(lists.at[list].width, subgroupBallotBitCount(here));
  return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(here);
#else
  return atomicAdd(lists.at[list].width, 1);
#endif
}

void append(uint64_t lists_address, uint64_t entries, RayEntry entry) {
  if (entry.wanted == 0) return;
  RayListRef lists = RayListRef(lists_address);
  const uint slot = next_index(lists, FIRE3DV_LIST_PIXELS);
  // The first entry of a group widens the dispatch.
  if ((slot & 63) == 0) widen(lists, FIRE3DV_LIST_PIXELS, slot + 1);
  RayEntryRef(entries).at[slot] = entry;
}

// On overflow the list OVERFLOW covers all pixels: their entries contain all rays, too.
void append(uint64_t lists_address, uint64_t listed_rays, uint capacity, uint pixels, ListedRay ray) {
  RayListRef lists = RayListRef(lists_address);
  const uint slot = next_index(lists, FIRE3DV_LIST_RAYS);
  if (slot < capacity) {
    ListedRayRef(listed_rays).at[slot] = ray;
  } else if (slot == capacity) {
    atomicMax(lists.at[FIRE3DV_LIST_OVERFLOW].width, pixels);
    widen(lists, FIRE3DV_LIST_OVERFLOW, pixels);
  }
}

#endif
