// The lists of what rays have to tell.
#ifndef FIRE3DV_RAY_LIST_GLSL
#define FIRE3DV_RAY_LIST_GLSL
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

// Lane by lane, since drivers gather that better than it could be done here.
void append(uint64_t lists_address, uint64_t entries, RayEntry entry) {
  if (entry.wanted == 0) return;
  RayListRef lists = RayListRef(lists_address);
  const uint place = atomicAdd(lists.at[FIRE3DV_LIST_PIXELS].width, 1);
  if ((place & 63) == 0) widen(lists, FIRE3DV_LIST_PIXELS, place + 1);  // whoever begins a group says so
  RayEntryRef(entries).at[place] = entry;
}

// Where not all can be written, all of the image's pixels are `left`: their entries tell of all rays, too.
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
