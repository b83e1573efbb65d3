// Surface of a material at a point: BRDF parameters from factors, textures and glTF extensions. Raster and path
// tracing share it.
#ifndef FIRE3DV_MATERIAL_SURFACE_GLSL
#define FIRE3DV_MATERIAL_SURFACE_GLSL
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "material/brdf.glsl"
#include "environment/environment.glsl"
#include "common/surface_point.glsl"

// Variant FIRE3DV_CORE_MATERIALS serves scenes without lobe-adding extensions: half of the registers, thus
// higher occupancy.
#ifdef FIRE3DV_CORE_MATERIALS
const bool kExtensions = false;
#else
const bool kExtensions = true;
#endif

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

// KHR_materials_anisotropy. Surfaces without tangents stay isotropic.
void add_anisotropy(MaterialExtensionRecord extension, SurfacePoint point, inout Surface surface) {
  const vec3 texel = sample_or(extension.anisotropy_texture, point.uv, point.uv_dx, point.uv_dy, vec4(1, 0.5, 1, 1)).rgb;
  const float strength = clamp(extension.anisotropy * texel.b, 0, 1);
  const vec3 normal = surface.base.normal;
  const vec3 in_plane = point.tangent_world.xyz - normal * dot(normal, point.tangent_world.xyz);
  if (strength == 0 || dot(in_plane, in_plane) < 1e-20) return;
  const vec3 tangent = normalize(in_plane);
  const vec3 bitangent = cross(normal, tangent) * (point.tangent_world.w < 0 ? -1 : 1);
  const vec2 along = texel.rg * 2 - 1, turn = extension.anisotropy_direction;
  const vec2 unturned = dot(along, along) > 1e-6 ? normalize(along) : vec2(1, 0);
  const vec2 direction = vec2(turn.x * unturned.x - turn.y * unturned.y, turn.y * unturned.x + turn.x * unturned.y);
  stretch(surface.base, surface.to_eye, direction.x * tangent + direction.y * bitangent, strength);
}

// KHR_materials_iridescence. A film without thickness has no effect.
Film film_of(MaterialExtensionRecord extension, SurfacePoint point) {
  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  Film film;
  film.ior = extension.iridescence_ior;
  film.thickness_nm = mix(extension.iridescence_thickness_nm.x, extension.iridescence_thickness_nm.y,
                          sample_or(extension.iridescence_thickness_texture, uv, dx, dy, vec4(1)).g);
  const float weight = extension.iridescence * sample_or(extension.iridescence_texture, uv, dx, dy, vec4(1)).r;
  film.weight = film.thickness_nm > 0 ? clamp(weight, 0, 1) : 0;
  return film;
}

// Adds the lobes of glTF extensions; the rest of the surface is complete.
void add_extensions(MaterialExtensionRecord extension, uint flags, float metallic, vec3 base_color, SurfacePoint point,
                    inout Surface surface) {
  const vec4 uv = point.uv, dx = point.uv_dx, dy = point.uv_dy;
  float refracted = 0;
  if ((flags & FIRE3DV_MATERIAL_TRANSMISSION) != 0) {
    refracted = extension.transmission * sample_or(extension.transmission_texture, uv, dx, dy, vec4(1)).r;
    surface.transmitted = refracted * (1 - metallic) * base_color;
    surface.diffuse *= 1 - refracted;
  }
  if (kDiffuseTransmission && (flags & FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION) != 0) {
    const float share =
        extension.diffuse_transmission * sample_or(extension.diffuse_transmission_texture, uv, dx, dy, vec4(1)).a;
    surface.passed = share * (1 - metallic) * (1 - refracted) * (1 - surface.body_albedo) *
                     extension.diffuse_transmission_color *
                     sample_or(extension.diffuse_transmission_color_texture, uv, dx, dy, vec4(1)).rgb;
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
    surface.coat_lobe = make_facets(normal, surface.to_eye, roughness);
    add_reflectance(surface.coat_lobe, surface.to_eye, vec3(0.04), 1, vec3(1), 0);
    surface.coat_interface = make_interface(0.04, 1, surface.coat_lobe.roughness);
  }
  if ((flags & (FIRE3DV_MATERIAL_SHEEN | FIRE3DV_MATERIAL_CLEARCOAT)) != 0)
    surface.base.layer_loss = lobe_layer_loss(surface.base, surface.to_eye, surface.base.n_dot_v);
}

// to_eye: unit, towards the viewer or the ray's origin.
Surface make_surface(GlobalsRef globals, MaterialRecord material, vec4 base_color, SurfacePoint point, vec3 to_eye) {
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
  surface.to_eye = to_eye;
  surface.diffuse = base_color.rgb * (1 - metallic);
  surface.transmitted = vec3(0);
  surface.passed = vec3(0);
  surface.base = make_facets(mapped_normal(material.normal_texture, material.normal_scale, point), surface.to_eye,
                             material.roughness * metallic_roughness.g);
  if (kAnisotropy && extended && (material.flags & FIRE3DV_MATERIAL_ANISOTROPY) != 0) {
    add_anisotropy(extension, point, surface);
  }
  add_reflectance(surface.base, surface.to_eye, dielectric_f0, dielectric_f90, base_color.rgb, metallic);
  surface.film.weight = 0;
  if (kIridescence && extended && (material.flags & FIRE3DV_MATERIAL_IRIDESCENCE) != 0) {
    surface.film = film_of(extension, point);
    surface.film.dielectric = 1 - metallic;
    surface.film.metal = metallic;
    surface.film.dielectric_f0 = dielectric_f0;
    surface.film.metal_f0 = base_color.rgb;
  }
  add_body(surface, largest(dielectric_f0), dielectric_f90);
  surface.sheen_color = vec3(0);
  surface.coat = 0;
  if (extended) add_extensions(extension, material.flags, metallic, base_color.rgb, point, surface);
  return surface;
}

#endif
