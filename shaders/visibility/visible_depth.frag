// Copy of the visibility buffer's depth to the depth attachment, which occludes forward-only draws. Variants:
// FIRE3DV_SAMPLES 1 or 4.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "common/pixel_ids.glsl"

layout(push_constant, scalar) uniform Push { VisibleDepthPush push; };

void main() {
  const uint pixel = uint(gl_FragCoord.y) * push.width + uint(gl_FragCoord.x);
#if FIRE3DV_SAMPLES == 4
  gl_FragDepth = decode_depth(SampleRef(push.visibility).at[pixel * FIRE3DV_SAMPLES + gl_SampleID].y, push.generation);
#else
  gl_FragDepth = decode_depth(SampleRef(push.visibility).at[pixel].y, push.generation);
#endif
}
