// Media of a path: the volumes (KHR_materials_volume) that it is inside of, and their boundaries. Each volume replaces
// those that the path entered before it.
#ifndef FIRE3DV_MEDIA_GLSL
#define FIRE3DV_MEDIA_GLSL
#include "common/buffers.glsl"
#include "common/textures.glsl"
#include "material/material_surface.glsl"
#include "material/transmission.glsl"
#include "path/hit.glsl"

bool is_volume(MaterialRecord material) { return kExtensions && (material.flags & FIRE3DV_MATERIAL_VOLUME) != 0; }

// Index of a colour channel (1: red, 2: green, 3: blue; 0: all of them) by Cauchy's formula of
// KHR_materials_dispersion, at the wavelengths that define the Abbe number: C, d and F of Fraunhofer.
float dispersed_ior(float ior, float dispersion, uint channel) {
  if (channel == 0 || dispersion == 0) return ior;
  const float wavelength_nm = channel == 1 ? 656.3 : channel == 2 ? 587.6 : 486.1;
  const float per_abbe = dispersion / 20;
  return max(ior + (ior - 1) * per_abbe * (523655 / (wavelength_nm * wavelength_nm) - 1.5168), 1);
}

float medium_ior(GlobalsRef globals, uint medium, uint channel) {
  if (medium == FIRE3DV_NO_INDEX) return 1;
  const MaterialRecord material = MaterialRef(globals.value.materials).at[medium];
  MaterialExtensionRef extensions = MaterialExtensionRef(globals.value.material_extensions);
  const float ior = extensions.at[material.extension].ior;
  return kDispersion ? dispersed_ior(ior, extensions.at[material.extension].dispersion, channel) : ior;
}

bool is_dispersive(MaterialRecord material) {
  return kDispersion && (material.flags & FIRE3DV_MATERIAL_DISPERSION) != 0;
}

// Beer-Lambert law.
vec3 transmittance(GlobalsRef globals, uint medium, float distance_m) {
  if (!kExtensions || medium == FIRE3DV_NO_INDEX) return vec3(1);
  const MaterialRecord material = MaterialRef(globals.value.materials).at[medium];
  return exp(-MaterialExtensionRef(globals.value.material_extensions).at[material.extension].absorption_per_m * distance_m);
}

// Media behind a surface of the volume. A path that is inside without having entered, such as a camera's, leaves to
// what it knows.
uvec4 media_behind(uvec4 media, uint volume, bool is_back) {
  if (!is_back) return uvec4(volume, media.xyz);
  if (media.x == volume) return uvec4(media.yzw, FIRE3DV_NO_INDEX);
  if (media.y == volume) return uvec4(media.x, media.zw, FIRE3DV_NO_INDEX);
  if (media.z == volume) return uvec4(media.xy, media.w, FIRE3DV_NO_INDEX);
  if (media.w == volume) return uvec4(media.xyz, FIRE3DV_NO_INDEX);
  return media;
}

// Medium of a ray that has hit a surface.
uint medium_before(uvec4 media, uint volume, PathVertex vertex, bool is_volume) {
  return media.x == FIRE3DV_NO_INDEX && is_volume && vertex.is_back ? volume : media.x;
}

struct Refraction {
  Boundary boundary;
  float share;     // of the surface
  vec3 f0;         // of the dielectric in air
};

// Boundary of a volume, and the share of the surface that it takes.
Refraction make_refraction(GlobalsRef globals, MaterialRecord material, vec4 base_color, Surface surface,
                           PathVertex vertex, uint volume, uvec4 media, uint channel) {
  const vec4 uv = vertex.point.uv;
  const MaterialExtensionRecord extension = MaterialExtensionRef(globals.value.material_extensions).at[material.extension];
  const float metallic =
      clamp(material.metallic * sample_or(material.metallic_roughness_texture, uv, vec4(0), vec4(0), vec4(1)).b, 0, 1);
  const float f90 = extension.specular * sample_or(extension.specular_texture, uv, vec4(0), vec4(0), vec4(1)).a;
  const vec3 specular_color = sample_or(extension.specular_color_texture, uv, vec4(0), vec4(0), vec4(1)).rgb;
  const bool is_covered = vertex.is_back && media.x != volume && any(equal(media, uvec4(volume)));
  const float before = medium_ior(globals, medium_before(media, volume, vertex, true), channel);
  const float behind = medium_ior(globals, media_behind(media, volume, vertex.is_back).x, channel);

  Refraction refraction;
  refraction.f0 = min(extension.dielectric_f0 * specular_color, 1) * f90;
  refraction.share =
      extension.transmission * sample_or(extension.transmission_texture, uv, vec4(0), vec4(0), vec4(1)).r * (1 - metallic);
  Boundary boundary;
  boundary.normal = surface.base.normal;
  // Anisotropic surfaces refract with the mean roughness.
  boundary.alpha = max(surface.base.roughness * surface.base.roughness, LEAST_ALPHA);
  boundary.ior = behind / before;
  // The specular colour holds for air.
  const float in_air = (extension.ior - 1) / (extension.ior + 1), here = (boundary.ior - 1) / (boundary.ior + 1);
  const vec3 per_ratio = in_air * in_air > 1e-12 ? extension.dielectric_f0 / (in_air * in_air) : vec3(1);
  boundary.f0 = min(here * here * per_ratio * specular_color, 1) * f90;
  boundary.f90 = f90;
  boundary.color = base_color.rgb;
  boundary.film = surface.film;
  // A volume entered later replaces this one, whose surface inside of it does not exist.
  if (is_covered) {
    refraction.share = 1;
    boundary.ior = 1;
    boundary.color = vec3(1);
    boundary.film.weight = 0;
  }
  refraction.boundary = boundary;
  return refraction;
}

#endif
