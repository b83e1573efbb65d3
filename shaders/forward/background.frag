// Background: radiance of the environment, gradient and shadow catcher in pixels without geometry.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "environment/environment.glsl"
#include "shading/ground.glsl"

layout(push_constant, scalar) uniform Push { ForwardPush push; };
layout(location = 0) in vec2 in_ndc;
layout(location = 0) out vec4 out_color;

void main() {
  GlobalsRef globals = GlobalsRef(push.globals);
  const vec3 direction = globals.value.world_from_ndc_x * in_ndc.x + globals.value.world_from_ndc_y * in_ndc.y +
                         globals.value.world_from_ndc_origin;
  const vec3 radiance = background_radiance(globals, direction) * ground_factor(globals, direction);
  out_color = vec4(min(radiance, vec3(65504)), is_background_display_referred(globals) ? 0 : 1);
}
