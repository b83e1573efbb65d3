// Shadow rays by ray query. Variants as in shading/trace.rgen.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef FIRE3DV_LISTED_RAYS
#include "shading/trace_listed.glsl"
#else
#include "shading/trace_entry.glsl"
#endif
#include "shading/shadow_rays.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ShadowPush push; };
// The image's globals; not 0 ends its draws, see gpu/submission_limits.h.
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly volatile buffer ImageGlobals { Globals globals; uint64_t ends_early; };
bool is_ended() { return ImageGlobals(push.globals).ends_early != 0ul; }

void main() {
#ifdef FIRE3DV_LISTED_RAYS
  // Strided loop: the list has a count, but no dispatch arguments.
  const uint count = listed_ray_count(push), step = gl_NumWorkGroups.x * gl_WorkGroupSize.x;
  for (uint index = gl_GlobalInvocationID.x; index < count && !is_ended(); index += step) {
    trace_listed(GlobalsRef(push.globals), ListedRayRef(push.listed_rays).at[index]);
  }
#else
  const uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * (65535 * 64);
  if (index >= RayListRef(push.lists).at[FIRE3DV_LIST_PIXELS].width || is_ended()) return;
  trace_entry(GlobalsRef(push.globals), push.visibility, RayEntryRef(push.entries).at[index]);
#endif
}
