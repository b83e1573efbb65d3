// Shading of a surface point: outgoing radiance towards the eye, shared by all raster paths.
#ifndef FIRE3DV_SHADING_GLSL
#define FIRE3DV_SHADING_GLSL
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "shading/brdf.glsl"
#include "environment/environment.glsl"
#include "shading/lights.glsl"
#include "common/surface_point.glsl"

// Variant FIRE3DV_CORE_MATERIALS serves scenes without lobe-adding extensions: half of the registers, thus
// higher occupancy.
#ifdef FIRE3DV_CORE_MATERIALS
const bool kExtensions = false;
#else
const bool kExtensions = true;
#endif

// Visible share of a light at the point, 0 to 1. The including shader defines it.
float light_visibility(uint light_index, LightSample light, SurfacePoint point);

vec4 surface_base_color(MaterialRecord material, SurfacePoint point) {
  return material.base_color * point.color *
         sample_or(material.base_color_texture, point.uv, point.uv_dx, point.uv_dy, vec4(1));
}

vec3 mapped_normal(TextureUse normal_texture, float normal_scale, SurfacePoint point) {
  if (!kTextures || normal_texture.texture == FIRE3DV_NO_INDEX) return point.normal_world;
  vec3 n = sample_or(normal_texture, point.uv, point.uv_dx, point.uv_dy, vec4(0.5, 0.5, 1, 1)).xyz * 2 - 1;
  n.xy *= normal_scale;
  const vec3 t = point.tangent_world.xyz - point.normal_world * dot(point.normal_world, point.tangent_world.xyz);
  if (dot(t, t) < 1e-20) return point.normal_world;
  const vec3 tangent = normalize(t);
  const vec3 bitangent = cross(point.normal_world, tangent) * point.tangent_world.w;
  return normalize(tangent * n.x + bitangent * n.y + point.normal_world * n.z);
}

// Adds the lobes of glTF extensions; the rest of the surface is complete.
void add_extensions(MaterialExtensionRecord extension, uint flags, float metallic, vec3 base_color, SurfacePoint point,
                    inout Surface surface) {
  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  if ((flags & FIRE3DV_MATERIAL_TRANSMISSION) != 0) {
    const float share = extension.transmission * sample_or(extension.transmission_texture, uv, dx, dy, vec4(1)).r;
    surface.transmitted = share * (1 - metallic) * base_color;
    surface.diffuse *= 1 - share;
  }
  if ((flags & FIRE3DV_MATERIAL_SHEEN) != 0) {
    const float roughness =
        clamp(extension.sheen_roughness * sample_or(extension.sheen_roughness_texture, uv, dx, dy, vec4(1)).a, 0, 1);
    surface.sheen_color = extension.sheen_color * sample_or(extension.sheen_color_texture, uv, dx, dy, vec4(1)).rgb;
    surface.sheen_roughness = roughness;
    surface.sheen_alpha = max(roughness * roughness, LEAST_SHEEN_ALPHA);
    surface.sheen_albedo = sheen_albedo_of(surface.base.n_dot_v, roughness);
  }
  if ((flags & FIRE3DV_MATERIAL_CLEARCOAT) != 0) {
    surface.coat = extension.clearcoat * sample_or(extension.clearcoat_texture, uv, dx, dy, vec4(1)).r;
    const float roughness =
        extension.clearcoat_roughness * sample_or(extension.clearcoat_roughness_texture, uv, dx, dy, vec4(1)).g;
    const vec3 normal = mapped_normal(extension.clearcoat_normal_texture, extension.clearcoat_normal_scale, point);
    surface.coat_lobe = make_lobe(normal, surface.to_eye, roughness, vec3(0.04), 1, vec3(1), 0);
    surface.coat_interface = make_interface(0.04, 1, surface.coat_lobe.roughness);
  }
}

Surface make_surface(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point) {
  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  const vec4 metallic_roughness = sample_or(material.metallic_roughness_texture, uv, dx, dy, vec4(1));
  const float metallic = clamp(material.metallic * metallic_roughness.b, 0, 1);
  vec3 dielectric_f0 = vec3(0.04);
  float dielectric_f90 = 1;
  const bool extended = kExtensions && material.extension != FIRE3DV_NO_INDEX;
  MaterialExtensionRecord extension;
  if (extended) {
    extension = MaterialExtensionRef(globals.value.material_extensions).at[material.extension];
    dielectric_f90 = extension.specular * sample_or(extension.specular_texture, uv, dx, dy, vec4(1)).a;
    dielectric_f0 = min(extension.dielectric_f0 * sample_or(extension.specular_color_texture, uv, dx, dy, vec4(1)).rgb, 1) *
                    dielectric_f90;
  }

  Surface surface;
  surface.to_eye = normalize(globals.value.eye_world - point.position_world);
  surface.diffuse = base_color.rgb * (1 - metallic);
  surface.transmitted = vec3(0);
  surface.base = make_lobe(mapped_normal(material.normal_texture, material.normal_scale, point), surface.to_eye,
                           material.roughness * metallic_roughness.g, dielectric_f0, dielectric_f90, base_color.rgb,
                           metallic);
  add_body(surface, largest(dielectric_f0), dielectric_f90);
  surface.sheen_color = vec3(0);
  surface.coat = 0;
  if (extended) add_extensions(extension, material.flags, metallic, base_color.rgb, point, surface);
  return surface;
}

vec3 reflected_of_light(uint index, LightSample light, Surface surface, SurfacePoint point) {
  const vec3 reflected = reflect_light(surface, light.to_light, light.sine) * light.irradiance;
  return largest(reflected) <= 0 ? vec3(0) : reflected * light_visibility(index, light, point);
}

#ifdef FIRE3DV_CPU
const uint kCachedLights = 2;
LightPose cached_lights[kCachedLights];  // the first lights

// Call it before lanes diverge.
void hold_lights(GlobalsRef globals) {
  if (globals.value.light_count == 0) return;
  for (uint i = 0; i < kCachedLights; ++i) {
    cached_lights[i] = light_for_all(globals.value.light_poses, min(i, globals.value.light_count - 1));
  }
}
#endif

bool is_display_referred;  // of the last call of shade(): the colour is shown as it is

// Linear HDR colour, premultiplied, and alpha. behind: transmittance of the background, per channel.
vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point, out vec3 behind) {
  const float kLargestHalf = 65504;  // largest finite half float of the target; larger values become
                                     // infinity, then NaN
  float alpha = 1;
  if ((material.flags & FIRE3DV_MATERIAL_BLEND) != 0) alpha = clamp(base_color.a, 0, 1);
  if ((material.flags & FIRE3DV_MATERIAL_MASK) != 0) alpha = base_color.a >= material.alpha_cutoff ? 1 : 0;
  behind = vec3(1 - alpha);
  is_display_referred = (material.flags & FIRE3DV_MATERIAL_UNLIT) != 0;
  if (is_display_referred) return vec4(min(base_color.rgb, vec3(kLargestHalf)) * alpha, alpha);

  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  const Surface surface = make_surface(globals, material, base_color, point);
  const float occlusion_sample = sample_or(material.occlusion_texture, uv, dx, dy, vec4(1)).r;
  const float occlusion = 1 + material.occlusion_strength * (occlusion_sample - 1);
  const float under_coat = surface.coat > 0 ? 1 - coat_albedo(surface) : 1;
  vec3 radiance = under_coat * material.emissive * sample_or(material.emissive_texture, uv, dx, dy, vec4(1)).rgb;
  radiance += reflect_environment(globals, surface, occlusion);

  uint i = 0;
#ifdef FIRE3DV_CPU
  const vec3 position = point.position_world;
  if (globals.value.light_count > 0) {
    radiance += reflected_of_light(0, sample_light(cached_lights[0], position), surface, point);
  }
  if (globals.value.light_count > 1) {
    radiance += reflected_of_light(1, sample_light(cached_lights[1], position), surface, point);
  }
  i = kCachedLights;
#endif
  for (; i < globals.value.light_count; ++i) {
    radiance += reflected_of_light(i, sample_light(globals, i, point.position_world), surface, point);
  }

  if (largest(surface.transmitted) > 0) {
    const float under_sheen = largest(surface.sheen_color) > 0 ? 1 - largest(surface.sheen_color) * surface.sheen_albedo : 1;
    behind += alpha * under_coat * under_sheen * (1 - surface.body_albedo) * surface.transmitted;
  }
  // The alpha serves users that blend by one value: the mean over the channels.
  return vec4(min(radiance, vec3(kLargestHalf)) * alpha, 1 - dot(behind, vec3(1.0 / 3.0)));
}

vec4 shade(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point) {
  vec3 behind;
  return shade(globals, material, base_color, point, behind);
}

#endif
