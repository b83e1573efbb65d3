// Test of material records in GPU layout: core materials stay small, and extensions are at the offsets that
// shaders read.
#include "renderer/passes/resources/scene_materials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>

namespace fire3dv::passes {
namespace {

TEST(MaterialRecords, PlainMaterialsHaveNoExtension) {
  std::vector<scene::Material> materials(3);
  materials[1].clearcoat = 0.5f;
  materials[2].unlit = true;
  materials[2].transmission = 1;  // unlit: only its colour counts
  const MaterialRecords records = material_records(materials);
  ASSERT_EQ(records.materials.size(), 3u);
  ASSERT_EQ(records.extensions.size(), 1u);
  EXPECT_EQ(records.materials[0].extension, FIRE3DV_NO_INDEX);
  EXPECT_EQ(records.materials[0].flags, 0u);
  EXPECT_EQ(records.materials[1].extension, 0u);
  EXPECT_EQ(records.materials[1].flags, FIRE3DV_MATERIAL_CLEARCOAT);
  EXPECT_EQ(records.materials[2].extension, FIRE3DV_NO_INDEX);
  EXPECT_EQ(records.extensions[0].clearcoat, 0.5f);
}

TEST(MaterialRecords, EachExtensionIsSeen) {
  std::vector<scene::Material> materials(9);
  materials[0].ior = 1.333f;
  materials[1].specular = 0.5f;
  materials[2].specular_color = {1, 0.5f, 0.25f};
  materials[3].specular_color_texture.texture = 4;
  materials[4].sheen_color = {0, 0, 0.1f};
  materials[5].transmission = 0.25f;
  materials[6].specular_texture.texture = 5;
  materials[7].anisotropy = 0.5f;
  materials[7].anisotropy_rotation_rad = 2;
  materials[8].iridescence = 0.5f;
  const MaterialRecords records = material_records(materials);
  ASSERT_EQ(records.extensions.size(), 9u);
  for (uint32_t i = 0; i < 9; ++i) EXPECT_EQ(records.materials[i].extension, i);
  EXPECT_NEAR(records.extensions[0].dielectric_f0.g, 0.02037f, 1e-5f);
  EXPECT_NEAR(records.extensions[1].dielectric_f0.g, 0.04f, 1e-6f);
  EXPECT_EQ(records.extensions[1].specular, 0.5f);
  EXPECT_NEAR(records.extensions[2].dielectric_f0.b, 0.01f, 1e-6f);
  EXPECT_EQ(records.extensions[3].specular_color_texture.texture, 4u);
  EXPECT_EQ(records.materials[4].flags, FIRE3DV_MATERIAL_SHEEN);
  EXPECT_EQ(records.materials[5].flags, FIRE3DV_MATERIAL_TRANSMISSION);
  EXPECT_EQ(records.extensions[5].transmission, 0.25f);
  EXPECT_EQ(records.extensions[6].specular_texture.texture, 5u);
  EXPECT_EQ(records.extensions[6].clearcoat_texture.texture, FIRE3DV_NO_INDEX);
  // Shaders of other scenes lack the code, and other materials need no tangents.
  EXPECT_EQ(records.materials[7].flags, FIRE3DV_MATERIAL_ANISOTROPY | FIRE3DV_MATERIAL_NORMAL_MAPPED);
  EXPECT_NEAR(records.extensions[7].anisotropy_direction.x, std::cos(2.0), 1e-6);
  EXPECT_NEAR(records.extensions[7].anisotropy_direction.y, std::sin(2.0), 1e-6);
  EXPECT_EQ(records.materials[8].flags, FIRE3DV_MATERIAL_IRIDESCENCE);
  EXPECT_EQ(records.extensions[8].iridescence_thickness_nm, glm::vec2(100, 400));
  EXPECT_EQ(optional_flags(materials), FIRE3DV_MATERIAL_ANISOTROPY | FIRE3DV_MATERIAL_IRIDESCENCE);
  EXPECT_EQ(optional_flags(std::span(materials).first(7)), 0u);
  EXPECT_TRUE(any_textured(materials));  // tangents are read
}

TEST(MaterialRecords, VolumesAbsorbByDistance) {
  std::vector<scene::Material> materials(6);
  for (scene::Material& material : materials) {
    material.transmission = 1;
    material.thickness = 0.5f;
    material.attenuation_color = {0.5f, 1, 0};
    material.attenuation_distance_m = 2;
  }
  materials[1].attenuation_distance_m = 0;  // infinite
  materials[2].thickness = 0;               // thin wall
  materials[3].ior = 0;                     // reflects everything
  materials[4].transmission = 0;
  materials[5].transmission = 0;
  materials[5].diffuse_transmission = 0.5f;
  const MaterialRecords records = material_records(materials);
  const auto is_volume = [&](size_t i) {
    return (records.materials[i].flags & FIRE3DV_MATERIAL_VOLUME) != 0;
  };
  EXPECT_TRUE(is_volume(0) && is_volume(1) && is_volume(5));
  EXPECT_FALSE(is_volume(2) || is_volume(3) || is_volume(4));
  EXPECT_NE(records.materials[5].flags & FIRE3DV_MATERIAL_DIFFUSE_TRANSMISSION, 0u);
  EXPECT_NEAR(records.extensions[0].absorption_per_m.r, 0.34657f, 1e-5f);  // ln 2 / 2 m
  EXPECT_EQ(records.extensions[0].absorption_per_m.g, 0);
  EXPECT_GT(records.extensions[0].absorption_per_m.b, 1e20f);
  EXPECT_EQ(records.extensions[1].absorption_per_m, glm::vec3(0));
}

// Shaders compute mip levels from the size.
TEST(MaterialRecords, TexturesSayTheirSizes) {
  scene::Scene scene;
  for (const glm::uvec2 size :
       {glm::uvec2(1, 1), glm::uvec2(300, 7), glm::uvec2(16384, 4097), glm::uvec2(1u << 20, 2)}) {
    scene::Image image;
    image.width = size.x;
    image.height = size.y;
    scene.images.push_back(image);
  }
  for (const uint32_t image : {3u, 2u, 1u, 0u}) scene.textures.push_back({.image = image});
  std::vector<scene::Material> materials(5);
  for (uint32_t i = 0; i < 4; ++i) materials[i].normal_texture.texture = i;
  materials[1].normal_texture.uv_set = 1;
  const auto use = [](const scene::Material& material, const TextureFacts& textures) {
    return material_records(std::span(&material, 1), textures).materials[0].normal_texture;
  };
  const glm::vec2 expected[] = {{65504, 2}, {16384, 4096}, {300, 7}, {1, 1}};
  for (const bool anisotropic : {false, true}) {
    const TextureFacts textures = texture_facts(scene, anisotropic);
    for (uint32_t i = 0; i < 4; ++i) {
      const gpu_types::TextureUse found = use(materials[i], textures);
      EXPECT_EQ(glm::unpackHalf2x16(found.size), expected[i]) << i;
      EXPECT_EQ(found.texture & FIRE3DV_TEXTURE_NUMBER, i);
      EXPECT_EQ((found.texture & FIRE3DV_TEXTURE_SECOND_UV) != 0, i == 1);
      EXPECT_EQ((found.texture & FIRE3DV_TEXTURE_ANISOTROPIC) != 0, anisotropic);
    }
    EXPECT_EQ(use(materials[4], textures).texture, FIRE3DV_NO_INDEX);
  }
  EXPECT_TRUE(any_second_uv(materials));
  materials[1].normal_texture.uv_set = 0;
  materials[4].normal_texture.uv_set = 1;  // of no texture
  EXPECT_FALSE(any_second_uv(materials));
}

TEST(MaterialRecords, TransmissiveIsBlended) {
  scene::Material material;
  EXPECT_EQ(scene::drawn_alpha_mode(material), scene::AlphaMode::opaque);
  material.transmission = 0.5f;
  EXPECT_EQ(scene::drawn_alpha_mode(material), scene::AlphaMode::blend);
  material.alpha_mode = scene::AlphaMode::mask;
  EXPECT_EQ(scene::drawn_alpha_mode(material), scene::AlphaMode::blend);
  material.unlit = true;
  EXPECT_EQ(scene::drawn_alpha_mode(material), scene::AlphaMode::mask);
}

TEST(LightRecords, RadiiAreHandedOn) {
  scene::Light light;
  light.radius_m = 0.1f;
  light.angular_radius_rad = 0.005f;
  EXPECT_EQ(light_record(light, 3).radius_m, 0.1f);
  EXPECT_EQ(light_record(light, 3).angular_radius_rad, 0.005f);
}

}  // namespace
}  // namespace fire3dv::passes
