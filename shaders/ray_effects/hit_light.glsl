// Light of lamps and environment at the hit of a ray-effect ray.
#ifndef FIRE3DV_HIT_LIGHT_GLSL
#define FIRE3DV_HIT_LIGHT_GLSL

// Of the ray. One ray: the hit has one shadow ray, to a lamp or into the environment, chosen by their shares of the
// unshadowed light. Otherwise each lamp has its rays, and the environment is not occluded.
bool takes_one_ray;
vec3 hit_choices;  // from 0 to 1: the choice, and a point of the lamp's disc or of the hemisphere

const uint kEnvironment = FIRE3DV_NO_INDEX;  // among lights

// The light seen from one point of its disc.
LightSample point_of_light(LightSample light, vec2 u) {
  const float radius = light.sine * sqrt(u.x), angle = 2 * PI * u.y;
  light.to_light = normalize(frame_around(light.to_light) *
                             vec3(radius * cos(angle), radius * sin(angle), sqrt(max(1 - radius * radius, 0))));
  return light;
}

float light_visibility(uint light_index, LightSample light, SurfacePoint point) {
  GlobalsRef globals = GlobalsRef(push.globals);
  LightShadow shadow;
  shadow.rays = 1;
  if (light_index != kEnvironment) {
    if (globals.value.shadows == FIRE3DV_SHADOWS_OFF) return 1;
    shadow = LightShadowRef(globals.value.light_shadows).at[light_index];
    if (takes_one_ray && shadow.rays > 1) light = point_of_light(light, hit_choices.yz);
    shadow.rays = min(shadow.rays, takes_one_ray ? 1 : push.reflection_rays);  // or as many as rays to hits
  }
  const vec3 origin =
      offset_from_surface(point.position_world, start_side(point, light.to_light), point.position_world, 0,
                          point.lift_m + start_height(point, light.to_light));
  return light_that_arrives(globals, shadow, light_index, light, origin, traced_pixel);
}

// Blur of the environment along a ray from a hit, so that a sun in it is no noise.
const float kEnvironmentRoughness = 0.6;

// A direction into the hemisphere, weighted by the cosine, above the triangle. irradiance: relative to the mean of all
// directions.
LightSample sample_environment(GlobalsRef globals, Surface surface, SurfacePoint point) {
  LightSample light = LightSample(sample_cosine(surface.base.normal, hit_choices.yz), kFar, vec3(0), 0);
  light.irradiance = reflected_radiance(globals, light.to_light, kEnvironmentRoughness) /
                     max(scattered_radiance(globals, surface.base.normal), vec3(1e-20));
  const vec3 plane = point.plane_normal_world;
  if (dot(light.to_light, plane) < 0) light.to_light = mirrored_at(plane, light.to_light);
  return light;
}

// The ray is chosen by weighted reservoir sampling, so that the BRDF occurs once in the code.
vec3 light_of_hit(GlobalsRef globals, Surface surface, SurfacePoint point, vec3 environment) {
  if (!kBounces) takes_one_ray = false;
  const uint lamps = globals.value.light_count, sources = takes_one_ray ? lamps + 1 : lamps;
  vec3 sum = takes_one_ray ? vec3(0) : environment, chosen = vec3(0);
  LightSample chosen_light = LightSample(vec3(0, 1, 0), kFar, vec3(0), 0);
  uint chosen_index = kEnvironment;
  float weights = 0, chosen_weight = 0, choice = hit_choices.x;
  for (uint i = 0; i < sources; ++i) {
    const bool is_lamp = i < lamps;
    uint index = is_lamp ? i : kEnvironment;
    LightSample light;
    vec3 reflected = environment;
    if (is_lamp) {
      light = sample_light(globals, i, point.position_world);
      reflected = reflect_light(surface, light.to_light, light.sine, is_above_surface(point, light.to_light)) * light.irradiance;
    } else {
      light = sample_environment(globals, surface, point);
    }
    if (takes_one_ray) {
      const float weight = largest(reflected);
      weights += weight;
      const float scaled = choice * weights;
      const bool takes = scaled < weight;
      // The rest of the number chooses on.
      choice = min(takes ? scaled / weight : (scaled - weight) / max(weights - weight, 1e-30), 0.9999999);
      if (takes) {
        chosen = reflected;
        chosen_weight = weight;
        chosen_light = light;
        chosen_index = index;
      }
      if (i + 1 < sources || chosen_weight <= 0) continue;
      reflected = chosen * (weights / chosen_weight);
      light = chosen_light;
      index = chosen_index;
      if (index == kEnvironment) reflected *= light.irradiance;
    }
    if (largest(reflected) > 0) sum += reflected * light_visibility(index, light, point);
  }
  return sum;
}

#endif
