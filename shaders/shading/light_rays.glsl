// Shadow rays from a surface to a light. The including shader defines is_shadowed().
#ifndef FIRE3DV_LIGHT_RAYS_GLSL
#define FIRE3DV_LIGHT_RAYS_GLSL
#include "shading/shadow_ray.glsl"

bool is_shadowed(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m);

// Rotation that varies per pixel but not per frame (Jimenez 2014, interleaved gradient noise).
float turn_of_pixel(GlobalsRef globals, uint pixel) {
  const vec2 position = vec2(pixel % globals.value.width, pixel / globals.value.width);
  return 6.2831853 * fract(52.9829189 * fract(dot(position, vec2(0.06711056, 0.00583715))));
}

// Visible share of the light from the origin. Rays to a soft light sample its disc evenly (Vogel's spiral).
float light_that_arrives(GlobalsRef globals, LightShadow shadow, uint light_index, LightSample light, vec3 origin,
                         uint pixel) {
  if (shadow.rays == 0) return 1;
  if (shadow.rays == 1) return is_shadowed(globals, origin, light.to_light, light.distance_m) ? 0 : 1;
  const uint rays = shadow.rays;
  const float turn = turn_of_pixel(globals, pixel);
  const vec3 helper = abs(light.to_light.y) < 0.9 ? vec3(0, 1, 0) : vec3(1, 0, 0);
  const vec3 right = normalize(cross(helper, light.to_light)), up = cross(light.to_light, right);
  const LightPose pose = LightPoseRef(globals.value.light_poses).at[light_index];
  const bool directional = pose.type == FIRE3DV_LIGHT_DIRECTIONAL;
  const float radius = directional ? tan(pose.angular_radius_rad) : pose.radius_m / light.distance_m;
  uint arrived = 0;
  for (uint k = 0; k < rays; ++k) {
    const float angle = turn + 2.3999632 * k, r = radius * sqrt((k + 0.5) / rays);
    const vec3 direction = light.to_light + r * (cos(angle) * right + sin(angle) * up);
    const float stretch = length(direction);
    if (!is_shadowed(globals, origin, direction / stretch, light.distance_m * stretch)) ++arrived;
  }
  return float(arrived) / rays;
}

#endif
