// Shadow rays by ray query. Variants: FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/trace_entry.glsl"
#include "common/shadow_rays.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ShadowPush push; };

void main() {
  const uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * (65535 * 64);
  if (index >= RayListRef(push.list).value.width) return;
  trace_entry(GlobalsRef(push.globals), push.visibility, RayEntryRef(push.entries).at[index]);
}
