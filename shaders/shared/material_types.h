// GPU records of materials and texture uses.
#ifndef FIRE3DV_SHARED_MATERIAL_TYPES_H
#define FIRE3DV_SHARED_MATERIAL_TYPES_H
#include "basics.h"

FIRE3DV_SHARED_BEGIN

// Flags beside the texture index.
#define FIRE3DV_TEXTURE_SECOND_UV 0x80000000u
#define FIRE3DV_TEXTURE_ANISOTROPIC 0x40000000u  // the sampler is anisotropic
#define FIRE3DV_TEXTURE_NUMBER 0x3fffffffu

struct TextureUse {
  uint texture;  // FIRE3DV_NO_INDEX: none
  uint size;     // of level 0, two halves; a size query on the device costs as much as a texel fetch
  vec2 uv_offset;
  // KHR_texture_transform: u' = dot(uv_rows.xy, uv) + offset.x, v' = dot(uv_rows.zw, uv) + offset.y
  vec4 uv_rows;
};

#define FIRE3DV_MATERIAL_DOUBLE_SIDED 1u
#define FIRE3DV_MATERIAL_UNLIT 2u
#define FIRE3DV_MATERIAL_MASK 4u
#define FIRE3DV_MATERIAL_BLEND 8u
#define FIRE3DV_MATERIAL_TRANSMISSION 16u
#define FIRE3DV_MATERIAL_SHEEN 32u
#define FIRE3DV_MATERIAL_CLEARCOAT 64u
#define FIRE3DV_MATERIAL_TEXTURED 128u       // required vertex attributes: texture coordinates,
#define FIRE3DV_MATERIAL_SECOND_UV 256u      // their second set,
#define FIRE3DV_MATERIAL_NORMAL_MAPPED 512u  // tangents
#define FIRE3DV_MATERIAL_ANISOTROPY 1024u
#define FIRE3DV_MATERIAL_IRIDESCENCE 2048u
#define FIRE3DV_MATERIAL_VOLUME 4096u  // KHR_materials_volume, for paths
#define FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION 8192u
#define FIRE3DV_MATERIAL_DISPERSION 16384u  // of a volume
// Light may arrive from the far side.
#define FIRE3DV_MATERIAL_PASSES_LIGHT \
  (FIRE3DV_MATERIAL_TRANSMISSION | FIRE3DV_MATERIAL_VOLUME | FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION)
// Compiled into the shaders of scenes that have them.
#define FIRE3DV_MATERIAL_OPTIONAL                                                                       \
  (FIRE3DV_MATERIAL_ANISOTROPY | FIRE3DV_MATERIAL_IRIDESCENCE | FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION | \
   FIRE3DV_MATERIAL_DISPERSION)

struct MaterialRecord {
  vec4 base_color;
  vec3 emissive;
  float metallic;
  float roughness;
  float normal_scale;
  float occlusion_strength;
  float alpha_cutoff;
  uint flags;
  uint extension;   // into MaterialExtensionRecord[]; FIRE3DV_NO_INDEX: core glTF only
  float thickness;  // of KHR_materials_volume, in the mesh's unit; 0: none
  uint padding;
  TextureUse base_color_texture;
  TextureUse metallic_roughness_texture;
  TextureUse normal_texture;
  TextureUse occlusion_texture;
  TextureUse emissive_texture;
};

// Parameters of glTF extensions, kept apart because few materials use them.
struct MaterialExtensionRecord {
  vec3 dielectric_f0;  // of KHR_materials_ior, times the specular colour
  float specular;
  vec3 sheen_color;
  float sheen_roughness;
  vec2 anisotropy_direction;  // cosine and sine of the rotation from the tangent to the bitangent
  float anisotropy;           // strength
  float iridescence;
  float iridescence_ior;
  vec2 iridescence_thickness_nm;  // minimum, maximum
  float clearcoat;
  float clearcoat_roughness;
  float clearcoat_normal_scale;
  float transmission;
  vec3 absorption_per_m;  // of KHR_materials_volume
  float ior;
  float dispersion;  // 20 / Abbe number
  float diffuse_transmission;
  vec3 diffuse_transmission_color;
  TextureUse specular_texture;
  TextureUse specular_color_texture;
  TextureUse clearcoat_texture;
  TextureUse clearcoat_roughness_texture;
  TextureUse clearcoat_normal_texture;
  TextureUse sheen_color_texture;
  TextureUse sheen_roughness_texture;
  TextureUse anisotropy_texture;
  TextureUse iridescence_texture;
  TextureUse iridescence_thickness_texture;
  TextureUse transmission_texture;
  TextureUse diffuse_transmission_texture;
  TextureUse diffuse_transmission_color_texture;
};

FIRE3DV_SHARED_END
#endif
