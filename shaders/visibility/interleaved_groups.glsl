// Workgroup distribution for load balance on CPUs (FIRE3DV_INTERLEAVED). On GPUs a workgroup processes the range of
// its own number. llvmpipe assigns each thread one contiguous run of groups before any begins, so one core
// would get the sky and another the ground. Consecutive groups therefore process rows 16 apart, in 16 rounds.
// Each thread's run then covers the whole image.
#ifndef FIRE3DV_INTERLEAVED_GROUPS_GLSL
#define FIRE3DV_INTERLEAVED_GROUPS_GLSL

const uint kListRow = 65535;  // maximum workgroups in x; the rest lie in y

#ifdef FIRE3DV_INTERLEAVED
const uint kRoundsShift = 4;

// Permutation of 0 to count - 1. count is below 2^28.
uint interleave(uint index, uint count) {
  const uint steps = index << kRoundsShift;
  uint turn = uint(float(steps) / float(count));  // rounds completed, with an error of at most one
  uint slot = steps - turn * count;
  if (int(slot) < 0) {
    slot += count;
    --turn;
  } else if (slot >= count) {
    slot -= count;
    ++turn;
  }
  // Where 16 and count share a factor, later rounds would repeat positions; the offset moves them on.
  return slot + (turn >> (kRoundsShift - min(kRoundsShift, uint(findLSB(count)))));
}

uvec2 image_group() { return uvec2(gl_WorkGroupID.x, interleave(gl_WorkGroupID.y, gl_NumWorkGroups.y)); }

// For several images of one size, one layer each in z.
uvec3 layers_group() {
  const uint rows = gl_NumWorkGroups.y;
  const uint row = interleave(gl_WorkGroupID.y + gl_WorkGroupID.z * rows, rows * gl_NumWorkGroups.z);
  const uint layer = uint((float(row) + 0.5) / float(rows));
  return uvec3(gl_WorkGroupID.x, row - layer * rows, layer);
}

uint list_group() {
  return interleave(gl_WorkGroupID.x + gl_WorkGroupID.y * kListRow, gl_NumWorkGroups.x * gl_NumWorkGroups.y);
}
#else
uvec2 image_group() { return gl_WorkGroupID.xy; }
uvec3 layers_group() { return gl_WorkGroupID; }
uint list_group() { return gl_WorkGroupID.x + gl_WorkGroupID.y * kListRow; }
#endif

#endif
