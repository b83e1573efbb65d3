// Which part of an image or a list a workgroup takes. With FIRE3DV_DEALT, on a device that is a CPU, not the one of its own
// number: there each thread of the driver is given one run of a dispatch's groups, as many as every other thread, before
// any has begun (llvmpipe), and of an image one would have the sky and another all that stands on the ground, so that one
// core waits for the other. Groups that follow each other take places that lie 16 apart instead, in 16 rounds: each
// thread's run, of however many threads, is spread over all of the image.
#ifndef FIRE3DV_DEALT_GROUPS_GLSL
#define FIRE3DV_DEALT_GROUPS_GLSL

const uint kListRow = 65535;  // groups that a dispatch has in x, at most; further ones lie in y

#ifdef FIRE3DV_DEALT
const uint kRoundsShift = 4;

// Each number below count once, for index from 0 to count - 1. count is below 2^28.
uint dealt(uint index, uint count) {
  const uint steps = index << kRoundsShift;
  uint turn = uint(float(steps) / float(count));  // how often all has been gone through: at most one too many or too few
  uint place = steps - turn * count;
  if (int(place) < 0) {
    place += count;
    --turn;
  } else if (place >= count) {
    place -= count;
    ++turn;
  }
  // Where 16 and count share a factor, a turn comes to the same places again and has to move on.
  return place + (turn >> (kRoundsShift - min(kRoundsShift, uint(findLSB(count)))));
}

uvec2 image_group() { return uvec2(gl_WorkGroupID.x, dealt(gl_WorkGroupID.y, gl_NumWorkGroups.y)); }

// Of several images, each a layer in z, as large as each other.
uvec3 layers_group() {
  const uint rows = gl_NumWorkGroups.y;
  const uint row = dealt(gl_WorkGroupID.y + gl_WorkGroupID.z * rows, rows * gl_NumWorkGroups.z);
  const uint layer = uint((float(row) + 0.5) / float(rows));
  return uvec3(gl_WorkGroupID.x, row - layer * rows, layer);
}

uint list_group() {
  return dealt(gl_WorkGroupID.x + gl_WorkGroupID.y * kListRow, gl_NumWorkGroups.x * gl_NumWorkGroups.y);
}
#else
uvec2 image_group() { return gl_WorkGroupID.xy; }
uvec3 layers_group() { return gl_WorkGroupID; }
uint list_group() { return gl_WorkGroupID.x + gl_WorkGroupID.y * kListRow; }
#endif

#endif
