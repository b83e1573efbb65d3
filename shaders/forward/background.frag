// Background: radiance of the environment, gradient and shadow catcher in pixels without geometry.
// Variant: FIRE3DV_VISIBLE_POSITION evaluates shadows at the mean of the visible samples of 4, like the compute path.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment.glsl"
#include "shading/ground.glsl"
#ifdef FIRE3DV_VISIBLE_POSITION
#extension GL_EXT_post_depth_coverage : require
layout(early_fragment_tests) in;
layout(post_depth_coverage) in;
#include "common/mean_sample_position.glsl"
#endif

layout(push_constant, scalar) uniform Push { ForwardPush push; };
layout(location = 0) out vec4 out_color;

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
#ifdef FIRE3DV_VISIBLE_POSITION
  const vec2 offset = mean_sample_position(uint(gl_SampleMaskIn[0]));
#else
  const vec2 offset = vec2(0);
#endif
  const vec3 radiance = background_of(globals, gl_FragCoord.xy, offset);
  out_color = vec4(min(radiance, vec3(65504)), is_background_display_referred(globals) ? 0 : 1);
}
