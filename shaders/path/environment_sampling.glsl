// Importance sampling of the environment image by an alias table of its luminance.
#ifndef FIRE3DV_ENVIRONMENT_SAMPLING_GLSL
#define FIRE3DV_ENVIRONMENT_SAMPLING_GLSL
#include "environment/environment.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EnvironmentCellRef { EnvironmentCell at[]; };

vec3 world_from_environment(GlobalsRef globals, vec3 direction) {
  const float c = globals.value.environment_turn.x, s = globals.value.environment_turn.y;
  return vec3(c * direction.x + s * direction.z, direction.y, c * direction.z - s * direction.x);
}

// Full resolution, as the background shows it.
vec3 environment_radiance(GlobalsRef globals, vec3 direction) {
  const vec2 uv = equirectangular_uv(environment_from_world(globals, direction));
  return globals.value.environment_intensity * textureLod(environment_background, uv, 0).rgb;
}

// A unit of u and v spans 2 pi^2 sin(angle from the pole) of solid angle.
float density_per_solid_angle(float density, float sine) { return sine > 1e-6 ? density / (2 * PI * PI * sine) : 0; }

float environment_pdf(GlobalsRef globals, PathParameters parameters, vec3 direction) {
  if (parameters.cells == 0ul) return 0;
  const vec3 local = environment_from_world(globals, direction);
  const uvec2 size = uvec2(parameters.cells_x, parameters.cells_y);
  const uvec2 cell = min(uvec2(clamp(equirectangular_uv(local), 0, 1) * vec2(size)), size - 1);
  const float density = EnvironmentCellRef(parameters.cells).at[cell.y * size.x + cell.x].density;
  return density_per_solid_angle(density, sqrt(max(1 - local.y * local.y, 0)));
}

// Direction in the world; its density is environment_pdf().
vec3 sample_environment(GlobalsRef globals, PathParameters parameters, uvec4 random) {
  EnvironmentCellRef cells = EnvironmentCellRef(parameters.cells);
  const uint count = parameters.cells_x * parameters.cells_y;
  uint high, low;
  umulExtended(random.x, count, high, low);  // high: floor(random * count)
  const EnvironmentCell cell = cells.at[high];
  const uint chosen = float(random.y >> 8u) * (1.0 / 16777216.0) < cell.threshold ? high : cell.alias;
  const vec2 within = vec2(random.zw >> 8u) * (1.0 / 16777216.0);
  const vec2 uv = (vec2(chosen % parameters.cells_x, chosen / parameters.cells_x) + within) /
                  vec2(parameters.cells_x, parameters.cells_y);
  const float turn = (uv.x - 0.5) * 2 * PI, angle = uv.y * PI;  // inverse of equirectangular_uv()
  const vec3 local = vec3(sin(angle) * sin(turn), cos(angle), -sin(angle) * cos(turn));
  return world_from_environment(globals, local);
}

#endif
