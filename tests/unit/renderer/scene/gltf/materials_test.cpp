// Test of glTF materials, textures, samplers and images.
#include <gtest/gtest.h>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using test::GltfBuilder;

TEST(SceneMaterials, FactorsAndExtensions) {
  GltfBuilder builder;
  builder.root["materials"] = {
      {{"name", "glow"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.6}}},
       {"emissiveFactor", {1, 0.5, 0}},
       {"alphaMode", "MASK"},
       {"alphaCutoff", 0.7},
       {"doubleSided", true},
       {"extensions",
        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}},
         {"KHR_materials_unlit", nlohmann::json::object()}}}},
      {{"name", "plain"}, {"alphaMode", "BLEND"}}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.materials.size(), 3u);
  const Material& glow = scene.materials[1];
  EXPECT_EQ(glow.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(glow.metallic, 0.5f);
  EXPECT_EQ(glow.roughness, 0.6f);
  EXPECT_EQ(glow.emissive, glm::vec3(4, 2, 0));
  EXPECT_EQ(glow.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(glow.alpha_cutoff, 0.7f);
  EXPECT_TRUE(glow.double_sided);
  EXPECT_TRUE(glow.unlit);
  const Material& plain = scene.materials[2];
  EXPECT_EQ(plain.alpha_mode, AlphaMode::blend);
  EXPECT_EQ(plain.metallic, 1);
  EXPECT_EQ(plain.base_color, glm::vec4(1));
  EXPECT_FALSE(plain.unlit);
}

TEST(SceneMaterials, SharedImageMakesTwoTextures) {
  GltfBuilder builder;
  builder.add_textured_material(test::png(3, 2, 0xff336699));
  builder.root["materials"][0]["normalTexture"] = {{"index", 0}, {"scale", 0.5}, {"texCoord", 1}};
  builder.root["materials"][0]["emissiveTexture"] = {{"index", 0}};
  builder.root["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9985}}};
  builder.root["textures"][0]["sampler"] = 0;
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0].width, 3u);
  EXPECT_EQ(scene.images[0].height, 2u);
  ASSERT_EQ(scene.images[0].rgba8.size(), 24u);
  EXPECT_EQ(scene.images[0].rgba8[0], 0x99);
  EXPECT_EQ(scene.images[0].rgba8[2], 0x33);
  const Material& material = scene.materials[1];
  ASSERT_EQ(scene.textures.size(), 2u);
  EXPECT_TRUE(scene.textures[material.base_color_texture.texture].srgb);
  EXPECT_FALSE(scene.textures[material.normal_texture.texture].srgb);
  EXPECT_EQ(material.emissive_texture.texture, material.base_color_texture.texture);
  EXPECT_EQ(material.normal_scale, 0.5f);
  EXPECT_EQ(material.normal_texture.uv_set, 1u);
  const Sampler& sampler = scene.textures[0].sampler;
  EXPECT_EQ(sampler.wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(sampler.wrap_v, Wrap::mirrored_repeat);
  EXPECT_TRUE(sampler.nearest_mag);
  EXPECT_FALSE(sampler.nearest_min);
  EXPECT_TRUE(sampler.nearest_mip);
}

TEST(SceneMaterials, TextureTransform) {
  GltfBuilder builder;
  builder.add_textured_material(test::png(1, 1, 0));
  builder.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
              ["KHR_texture_transform"] = {
      {"offset", {0.5, 0.25}}, {"rotation", 1.5}, {"scale", {2, 3}}, {"texCoord", 1}};
  const Scene scene = loaded(builder);
  const TextureRef& ref = scene.materials[1].base_color_texture;
  EXPECT_EQ(ref.uv_offset, glm::vec2(0.5, 0.25));
  EXPECT_EQ(ref.uv_scale, glm::vec2(2, 3));
  EXPECT_EQ(ref.uv_rotation_rad, 1.5f);
  EXPECT_EQ(ref.uv_set, 1u);
}

TEST(SceneMaterials, UnreadableImageIsWarned) {
  GltfBuilder builder;
  builder.root["textures"] = {{{"extensions", {{"MSFT_texture_dds", {{"source", 0}}}}}}};
  builder.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.materials[1].base_color_texture.texture, kNone);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(SceneMaterials, ImagesKeepTheirOrder) {
  GltfBuilder builder;
  const test::ScratchFolder folder;
  for (int i = 0; i < 20; ++i) {
    const std::string name = "image" + std::to_string(i) + ".png";
    folder.write(name, test::png(i + 1, 1, 0xff000000u + static_cast<uint32_t>(i)));
    builder.root["images"].push_back({{"uri", name}});
    builder.root["textures"].push_back({{"source", i}});
    builder.root["materials"].push_back({{"emissiveTexture", {{"index", i}}}});
  }
  const auto scene = load_gltf(folder.write("scene.gltf", builder.root.dump()));
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->images.size(), 20u);
  for (uint32_t i = 0; i < 20; ++i) {
    const Image& image =
        scene->images[scene->textures[scene->materials[i + 1].emissive_texture.texture].image];
    EXPECT_EQ(image.width, i + 1);
    EXPECT_EQ(image.rgba8[0], i);
  }
}

}  // namespace
}  // namespace fire3dv::scene
