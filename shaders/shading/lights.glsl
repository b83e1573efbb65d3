// Light sampling after KHR_lights_punctual.
#ifndef FIRE3DV_LIGHTS_GLSL
#define FIRE3DV_LIGHTS_GLSL
#include "common/buffers.glsl"

struct LightSample {
  vec3 to_light;      // unit
  float distance_m;   // directional lights: beyond any scene
  vec3 irradiance;    // perpendicular to to_light, unshadowed
  float sine;         // of half the angle that the source subtends; 0: a point
};

LightSample sample_light(LightPose light, vec3 position_world) {
  LightSample result;
  if (light.type == FIRE3DV_LIGHT_DIRECTIONAL) {
    result.to_light = -light.light_direction_world;
    result.distance_m = 1e30;
    result.irradiance = light.color;
    result.sine = light.sine;
    return result;
  }
  const vec3 offset = light.position_world - position_world;
  const float distance2 = max(dot(offset, offset), 1e-12);
  result.distance_m = sqrt(distance2);
  result.to_light = offset / result.distance_m;
  float attenuation = 1 / distance2;
  if (light.range_m > 0) {
    const float ratio2 = distance2 / (light.range_m * light.range_m);
    attenuation *= clamp(1 - ratio2 * ratio2, 0, 1);
  }
  if (light.type == FIRE3DV_LIGHT_SPOT) {
    const float cone = clamp(dot(light.light_direction_world, -result.to_light) * light.cone_scale + light.cone_offset, 0, 1);
    attenuation *= cone * cone;
  } else if (light.type == FIRE3DV_LIGHT_LAMP) {
    attenuation *= exp(light.cone_scale * (dot(light.light_direction_world, -result.to_light) - 1));
  }
  result.irradiance = light.color * attenuation;
  result.sine = light.radius_m / max(result.distance_m, light.radius_m + 1e-12);
  return result;
}

LightSample sample_light(GlobalsRef globals, uint light_index, vec3 position_world) {
  return sample_light(LightPoseRef(globals.value.light_poses).at[light_index], position_world);
}

#endif
