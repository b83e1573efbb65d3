// Unidirectional path tracing with next event estimation (Kajiya 1986). Lamps are sampled directly; the environment
// is sampled by image and by BRDF, weighted by the balance heuristic (Veach and Guibas 1995). The including shader
// traces the rays: closest_hit() and is_blocked().
#ifndef FIRE3DV_PATH_GLSL
#define FIRE3DV_PATH_GLSL
#define FIRE3DV_PATH_TRACED
#include "path/environment_sampling.glsl"
#include "path/hit.glsl"
#include "path/media.glsl"
#include "material/brdf_sampling.glsl"
#include "shading/ground.glsl"
#include "material/material_surface.glsl"
#include "shading/shadow_ray.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer PathParametersRef { PathParameters value; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer PathStateRef { PathState at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer PathSumRef { PathSum at[]; };

Hit closest_hit(GlobalsRef globals, vec3 origin, float near_m, vec3 direction, float far_m, bool is_camera_ray, uvec4 random);
bool is_blocked(GlobalsRef globals, vec3 origin, vec3 direction, float distance_m, uvec4 random);

const float kFar = 1e30;
// Random numbers of a path vertex.
const uint kDimensions = 64;
const uint kOfRay = 0, kOfDirection = 1, kOfEnvironment = 2, kOfSurvival = 3, kOfEnvironmentRay = 4, kOfBoundary = 5,
           kOfLamp = 8, kOfLampRay = kOfLamp + FIRE3DV_PATH_LAMPS, kOfGround = 32, kOfPixel = 40, kOfWalk = 48;
const uint kCertainVertices = 4;  // before Russian roulette

uvec4 path_counter;  // pixel, sample, first dimension of the vertex, seed

uvec4 random_words(uint dimension) { return pcg4d(path_counter + uvec4(0, 0, dimension, 0)); }

// Direction to a point of the lamp, which subtends half of the angle arcsin(light.sine). The lamp's radiance is
// uniform over the cone, so that its irradiance does not depend on its size. Returns the factor on it.
float sample_lamp(inout LightSample light, vec2 u) {
  if (light.sine <= 0) return 1;
  const float least_cosine = sqrt(max(1 - light.sine * light.sine, 0));
  const float cosine = mix(1, least_cosine, u.x), sine = sqrt(max(1 - cosine * cosine, 0)), angle = 2 * PI * u.y;
  light.to_light = normalize(frame_around(light.to_light) * vec3(sine * cos(angle), sine * sin(angle), cosine));
  return 2 / (1 + least_cosine);
}

float ground_visibility(GlobalsRef globals, uint light_index, LightSample light, vec3 position_world) {
  if (LightShadowRef(globals.value.light_shadows).at[light_index].rays == 0) return 1;
  const uvec4 random = random_words(kOfGround + light_index * kDimensions);
  sample_lamp(light, unit_numbers(random).xy);
  const vec3 origin = offset_from_surface(position_world, vec3(0, 1, 0), globals.value.eye_world, 0, 0);
  return is_blocked(globals, origin, light.to_light, light.distance_m, random) ? 0 : 1;
}

uvec4 media_of(PathState path) { return uvec4(path.media[0], path.media[1], path.media[2], path.media[3]); }

void set_media(inout PathState path, uvec4 media) {
  for (int i = 0; i < 4; ++i) path.media[i] = media[i];
}

// Ends the path and adds it to the pixel's sums, so that samples are summed in their order.
void end_path(inout PathState path, inout PathSum sum, bool is_display_referred) {
  path.vertex = FIRE3DV_NO_INDEX;
  sum.samples += 1;
  if (is_display_referred) {
    sum.display += path.radiance;
    return;
  }
  sum.radiance += path.radiance;
  sum.radiance_samples += 1;
}

// Moves a camera ray from the lens's centre to a point of its disc; rays of one point of the plane in focus stay together
// (Cook et al. 1984). along: the ray's direction, with length 1 along the view direction.
void pass_lens(PathParameters parameters, vec3 along, vec2 u, inout PathState path) {
  const float radius = sqrt(u.x), angle = 2 * PI * u.y;
  const vec3 offset = radius * (cos(angle) * parameters.lens_x_m + sin(angle) * parameters.lens_y_m);
  path.origin_world += offset;
  path.direction_world = normalize(along * parameters.focus_distance_m - offset);
}

// Direction from the eye to the point of the ground plane that a camera ray meets.
vec3 direction_to_ground(GlobalsRef globals, PathParameters parameters, PathState path) {
  const vec3 direction = path.direction_world;
  const float above_m = path.origin_world.y - globals.value.ground_height_m;
  if (parameters.focus_distance_m <= 0 || direction.y >= 0 || above_m <= 0) return direction;
  return path.origin_world - direction * (above_m / direction.y) - globals.value.eye_world;
}

void begin_path(GlobalsRef globals, PathParameters parameters, uint pixel, out PathState path) {
  const vec4 u = unit_numbers(random_words(kOfPixel));
  const vec2 position = vec2(pixel % globals.value.width, pixel / globals.value.width) + u.xy;
  const vec2 ndc = position / vec2(globals.value.width, globals.value.height) * 2 - 1;
  path.origin_world = globals.value.eye_world + parameters.origin_x * ndc.x + parameters.origin_y * ndc.y;
  const vec3 along =
      globals.value.world_from_ndc_x * ndc.x + globals.value.world_from_ndc_y * ndc.y + globals.value.world_from_ndc_origin;
  path.direction_world = normalize(along);
  if (parameters.focus_distance_m > 0) pass_lens(parameters, along, u.zw, path);
  path.pdf = 0;
  path.vertex = 0;
  path.throughput = vec3(1);
  path.is_camera_ray = 1;
  path.radiance = vec3(0);
  set_media(path, uvec4(FIRE3DV_NO_INDEX));
  path.channel = 0;
}

void leave_scene(GlobalsRef globals, PathParameters parameters, inout PathState path, inout PathSum sum) {
  const vec3 direction = path.direction_world;
  if (path.is_camera_ray != 0) {
    path.radiance = background_radiance(globals, direction) * ground_factor(globals, direction_to_ground(globals, parameters, path));
    end_path(path, sum, is_background_display_referred(globals));
    return;
  }
  const float by_light = environment_pdf(globals, parameters, direction);
  path.throughput *= transmittance(globals, path.media[0], kFar);
  if (globals.value.environment_intensity > 0)
    path.radiance += path.throughput * environment_radiance(globals, direction) * (path.pdf / (path.pdf + by_light));
  end_path(path, sum, false);
}

// Surface of a path vertex that scatters light: either the opaque surface or the boundary of a volume.
struct Scatterer {
  Surface surface;
  LobeShares shares;
  float passed_share;  // of sampled directions, for diffuse transmission
  bool is_boundary;
  Boundary boundary;
  uvec4 media_behind;  // on the side away from the eye
};

// Next direction of a path.
struct Step {
  vec3 direction;
  vec3 weight;
  float pdf;  // kFar: all light of this direction comes by sampled directions. 0: the path ends
};

bool is_behind(PathVertex vertex, vec3 direction) { return starts_behind(vertex.point, direction); }

vec3 origin_towards(PathVertex vertex, vec3 direction) {
  return offset_from_surface(vertex.point.position_world, start_side(vertex.point, direction), vertex.point.position_world, 0,
                             vertex.rounding_m + start_height(vertex.point, direction));
}

// Scattered radiance per unit of irradiance perpendicular to the direction, and the density of sampling it.
// seed: random.
vec3 scatter_light(Scatterer on, PathVertex vertex, vec3 direction, uvec4 seed, out float pdf) {
  if (kExtensions && on.is_boundary) {
    // Light must pass where both the shading normal and the triangle say so.
    const bool passes = dot(on.boundary.normal, direction) < 0;
    pdf = boundary_pdf(on.boundary, on.surface.to_eye, direction);
    if (passes != is_behind(vertex, direction) || (passes && is_smooth(on.boundary))) return vec3(0);
    return walk_boundary(on.boundary, on.surface.to_eye, seed, direction).scattered;
  }
  const vec3 scattered = reflect_light(on.surface, direction, 0, is_above_surface(vertex.point, direction));
  pdf = largest(scattered) > 0 ? pdf_of(on.surface, on.shares, direction) : 0;
  if (kDiffuseTransmission && on.passed_share > 0)
    pdf = mix(pdf, cosine_pdf(-on.surface.base.normal, direction), on.passed_share);
  return scattered;
}

Step step_through(Boundary boundary, PathVertex vertex, vec3 to_eye, uvec4 seed) {
  if (abs(boundary.ior - 1) < kNoRefraction) return Step(-to_eye, boundary.color, kFar);
  const BoundaryWalk walk = walk_boundary(boundary, to_eye, seed, vec3(0));
  Step next = Step(walk.direction, walk.weight, kFar);
  const bool passes = dot(boundary.normal, walk.direction) < 0;
  if (passes != is_behind(vertex, walk.direction)) {
    next.direction = mirrored_at(vertex.point.plane_normal_world, walk.direction);
  } else if (!is_smooth(boundary)) {
    next.pdf = boundary_pdf(boundary, to_eye, walk.direction);
  }
  return next;
}

// Direct light, and the next direction. False: the path ends.
bool scatter(GlobalsRef globals, PathParameters parameters, Scatterer on, PathVertex vertex, inout PathState path) {
  const uint lamps = min(globals.value.light_count, FIRE3DV_PATH_LAMPS);
  const bool is_straight = kExtensions && on.is_boundary && abs(on.boundary.ior - 1) < kNoRefraction;
  Step next = Step(vec3(0), vec3(0), 0);
  // One loop, so that the BRDF occurs once in the code: lamps, the environment, the next direction.
  for (uint i = 0; i < lamps + 2; ++i) {
    vec3 direction, incoming = vec3(0);
    float distance_m = kFar, light_pdf = 0;
    bool casts_shadow = true;
    uvec4 ray_random = uvec4(0);
    if (i < lamps) {
      if (is_straight) continue;
      const uvec4 words = random_words(kOfLamp + i);
      const vec4 u = unit_numbers(words);
      // One lamp of each stratum of the list.
      const uint lamp = globals.value.light_count == lamps
                            ? i
                            : min(uint((i + u.z) / lamps * globals.value.light_count), globals.value.light_count - 1);
      LightSample light = sample_light(globals, lamp, vertex.point.position_world);
      incoming = light.irradiance * (float(globals.value.light_count) / lamps) * sample_lamp(light, u.xy);
      direction = light.to_light;
      distance_m = light.distance_m;
      casts_shadow = LightShadowRef(globals.value.light_shadows).at[lamp].rays != 0;
      ray_random = random_words(kOfLampRay + i);
    } else if (i == lamps) {
      if (parameters.cells == 0ul || is_straight) continue;
      if (kExtensions && on.is_boundary && is_smooth(on.boundary)) continue;
      direction = sample_environment(globals, parameters, random_words(kOfEnvironment));
      light_pdf = environment_pdf(globals, parameters, direction);
      if (!(light_pdf > 0)) continue;
      incoming = environment_radiance(globals, direction) / light_pdf;
      ray_random = random_words(kOfEnvironmentRay);
    } else {
      if (kExtensions && on.is_boundary) {
        next = step_through(on.boundary, vertex, on.surface.to_eye, random_words(kOfWalk + i));
        continue;
      }
      const vec4 u = unit_numbers(random_words(kOfDirection));
      if (kDiffuseTransmission && u.w < on.passed_share) {
        direction = sample_cosine(-on.surface.base.normal, u.yz);
      } else {
        direction = sample_direction(on.surface, on.shares, u.x, u.yz);
      }
    }
    float pdf;
    const vec3 scattered = scatter_light(on, vertex, direction, random_words(kOfWalk + i), pdf);
    if (!(largest(scattered) > 0)) continue;
    if (i == lamps + 1) {
      next = Step(direction, scattered / pdf, pdf);
      continue;
    }
    if (i == lamps) incoming *= light_pdf / (light_pdf + pdf);
    const vec3 contribution = path.throughput * scattered * incoming;
    if (!(largest(contribution) > 0)) continue;
    if (casts_shadow && is_blocked(globals, origin_towards(vertex, direction), direction, distance_m, ray_random)) continue;
    path.radiance += contribution * transmittance(globals, is_behind(vertex, direction) ? on.media_behind.x : path.media[0], distance_m);
  }
  if (!(next.pdf > 0)) return false;
  path.origin_world = origin_towards(vertex, next.direction);
  path.direction_world = next.direction;
  path.throughput *= next.weight;
  path.pdf = next.pdf;
  if (is_behind(vertex, next.direction)) set_media(path, on.media_behind);
  return true;
}

// Russian roulette: a path of little throughput ends with the complement of its chance to survive, by which the
// others are divided.
// Radiance inside of a volume is larger by the square of its index.
bool survives(GlobalsRef globals, inout PathState path) {
  if (path.vertex < kCertainVertices) return true;
  const float ior = kExtensions ? medium_ior(globals, path.media[0], path.channel) : 1;
  const float chance = clamp(largest(path.throughput) * ior * ior, 0.05, 1);
  if (unit_numbers(random_words(kOfSurvival)).x >= chance) return false;
  path.throughput /= chance;
  return true;
}

// A volume's surface scatters as a boundary with the chance of its transparent share, else as the rest. Layers above
// it, on the outside, take their albedo of the share.
void choose_scatterer(GlobalsRef globals, MaterialRecord material, vec4 base_color, PathVertex vertex,
                      inout PathState path, inout Scatterer on) {
  on.is_boundary = false;
  on.passed_share = 0;
  on.media_behind = media_of(path);
  if (is_volume(material)) {
    const uint volume = vertex.point.material;
    // The path stands for one of three colours from its first dispersive volume on, with three times its radiance.
    if (path.channel == 0 && is_dispersive(material)) {
      path.channel = 1 + min(uint(3 * unit_numbers(random_words(kOfBoundary)).y), 2);
      path.throughput *= 3 * vec3(path.channel == 1, path.channel == 2, path.channel == 3);
    }
    const Refraction refraction =
        make_refraction(globals, material, base_color, on.surface, vertex, volume, media_of(path), path.channel);
    on.media_behind = media_behind(media_of(path), volume, vertex.is_back);
    if (vertex.is_back) {
      on.surface.coat = 0;
      on.surface.sheen_color = vec3(0);
    }
    const float chance = refraction.share * passes_layers(on.surface);
    on.is_boundary = unit_numbers(random_words(kOfBoundary)).x < chance;
    on.boundary = refraction.boundary;
    on.surface = without_boundary(on.surface, refraction.share, refraction.f0, refraction.boundary.f90);
    if (!on.is_boundary) path.throughput /= 1 - chance;
  }
  if (on.is_boundary) return;
  on.passed_share = passed_share(on.surface);
  on.shares = lobe_shares(on.surface);
}

// One ray, and the surface that it hits.
void advance_path(GlobalsRef globals, PathParameters parameters, inout PathState path, inout PathSum sum) {
  const bool is_camera_ray = path.is_camera_ray != 0;
  const float along = is_camera_ray ? max(dot(path.direction_world, parameters.look_world), 1e-6) : 1;
  const float near_m = is_camera_ray ? parameters.near_m / along : 0;
  const float far_m = is_camera_ray && parameters.far_m > 0 ? parameters.far_m / along : kFar;
  const Hit hit = closest_hit(globals, path.origin_world, near_m, path.direction_world, far_m, is_camera_ray, random_words(kOfRay));
  if (!hit.found) {
    leave_scene(globals, parameters, path, sum);
    return;
  }

  const PrimitiveRecord primitive = primitive_of_hit(globals, hit.node, hit.geometry);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[primitive.material];
  const PathVertex vertex = path_vertex(globals, hit, primitive, material, path.direction_world);
  const vec4 base_color = surface_base_color(material, vertex.point);
  const uvec4 media = media_of(path);
  path.throughput *= transmittance(globals, medium_before(media, vertex.point.material, vertex, is_volume(material)),
                                   distance(vertex.point.position_world, path.origin_world));
  if ((material.flags & FIRE3DV_MATERIAL_UNLIT) != 0) {
    path.radiance += path.throughput * base_color.rgb;
    end_path(path, sum, is_camera_ray);
    return;
  }
  Scatterer on;
  on.surface = make_surface(globals, material, base_color, vertex.point, -path.direction_world);
  const Surface surface = on.surface;
  const bool emits = !vertex.is_back || (material.flags & FIRE3DV_MATERIAL_DOUBLE_SIDED) != 0;
  if (emits && largest(material.emissive) > 0) {
    const float under_coat = surface.coat > 0 ? 1 - coat_albedo(surface) : 1;
    path.radiance += path.throughput * under_coat * material.emissive *
                     sample_or(material.emissive_texture, vertex.point.uv, vec4(0), vec4(0), vec4(1)).rgb;
  }
  choose_scatterer(globals, material, base_color, vertex, path, on);
  const bool goes_on = path.vertex <= parameters.bounces && scatter(globals, parameters, on, vertex, path) && survives(globals, path);
  if (!goes_on) {
    end_path(path, sum, false);
    return;
  }
  path.is_camera_ray = 0;
  ++path.vertex;
}

void trace_pixel(PathPush push, uint slot) {
  GlobalsRef globals = GlobalsRef(push.globals);
  const PathParameters parameters = PathParametersRef(push.parameters).value;
  const uint pixel = push.first_pixel + slot;
  path_counter = uvec4(pixel, push.sample_index, 0, parameters.seed);
  PathState path;
  if (push.begins != 0) {
    begin_path(globals, parameters, pixel, path);
  } else {
    path = PathStateRef(parameters.states).at[slot];
    if (path.vertex == FIRE3DV_NO_INDEX) return;
  }
  PathSum sum = PathSumRef(parameters.sums).at[pixel];
  for (uint i = 0; i < push.segments; ++i) {
    if (path.vertex == FIRE3DV_NO_INDEX) break;
    path_counter.z = path.vertex * kDimensions;
    advance_path(globals, parameters, path, sum);
  }
  PathStateRef(parameters.states).at[slot] = path;
  if (path.vertex == FIRE3DV_NO_INDEX) PathSumRef(parameters.sums).at[pixel] = sum;
}

#endif
