// Test of KHR_materials_pbrSpecularGlossiness: colours against the definitions of both material models.
#include "renderer/scene/gltf/specular_glossiness.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

TEST(SpecularGlossiness, ColoursAreKept) {
  const MetallicRoughness plastic =
      to_metallic_roughness({{0.2f, 0.5f, 0.8f, 0.7f}, glm::vec3(0.04f), 0.75f});
  EXPECT_NEAR(plastic.metallic, 0, 1e-4f);
  EXPECT_NEAR(glm::distance(plastic.base_color, glm::vec4(0.2f, 0.5f, 0.8f, 0.7f)), 0, 1e-4f);
  EXPECT_EQ(plastic.roughness, 0.25f);
  const glm::vec3 gold(1, 0.766f, 0.336f);
  const MetallicRoughness metal = to_metallic_roughness({{0, 0, 0, 1}, gold, 1});
  EXPECT_NEAR(metal.metallic, 1, 1e-4f);
  EXPECT_NEAR(glm::distance(glm::vec3(metal.base_color), gold), 0, 1e-4f);
  EXPECT_EQ(metal.roughness, 0);
}

// For greys the conversion is exact: metallic-roughness reproduces the diffuse and the specular colour.
TEST(SpecularGlossiness, GreysAreReproduced) {
  for (float diffuse = 0.05f; diffuse < 0.9f; diffuse += 0.1f) {
    for (float specular = 0.04f; specular < 0.9f; specular += 0.1f) {
      const auto made = to_metallic_roughness({glm::vec4(glm::vec3(diffuse), 1), glm::vec3(specular), 0.5f});
      const float base = made.base_color.r, metallic = made.metallic;
      if (base >= 1) continue;  // clamped
      EXPECT_NEAR(0.04f * (1 - metallic) + base * metallic, specular, 0.05f) << diffuse << ' ' << specular;
      EXPECT_NEAR(base * (1 - 0.04f) * (1 - metallic), diffuse * (1 - specular), 0.05f)
          << diffuse << ' ' << specular;
    }
  }
}

GltfBuilder with_material(json specular_glossiness) {
  GltfBuilder builder;
  builder.add_textured_material(test::png(2, 2, 0xff0000ff));
  builder.root["materials"][0] = {
      {"extensions", {{"KHR_materials_pbrSpecularGlossiness", std::move(specular_glossiness)}}}};
  builder.root["extensionsRequired"] = {"KHR_materials_pbrSpecularGlossiness"};
  return builder;
}

// Adds a texture of one colour; returns its index.
size_t add_texture(GltfBuilder& builder, int width, int height, uint32_t rgba) {
  const auto bytes = test::png(width, height, rgba);
  builder.root["images"].push_back({{"bufferView", builder.add_view(bytes)}, {"mimeType", "image/png"}});
  builder.root["textures"].push_back({{"source", builder.root["images"].size() - 1}});
  return builder.root["textures"].size() - 1;
}

glm::ivec4 first_texel(const Scene& scene, const TextureRef& ref) {
  const Image& image = scene.images[scene.textures[ref.texture].image];
  return {image.rgba8[0], image.rgba8[1], image.rgba8[2], image.rgba8[3]};
}

TEST(SpecularGlossiness, FactorsOfAFile) {
  const Scene scene = loaded(with_material(
      {{"diffuseFactor", {0, 0, 0, 0.5}}, {"specularFactor", {1, 0.5, 0.25}}, {"glossinessFactor", 0.25}}));
  const Material& material = scene.materials[1];
  EXPECT_NEAR(glm::distance(material.base_color, glm::vec4(1, 0.5f, 0.25f, 0.5f)), 0, 1e-3f);
  EXPECT_NEAR(material.metallic, 1, 1e-3f);
  EXPECT_EQ(material.roughness, 0.75f);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "extensions that are approximated: \"KHR_materials_pbrSpecularGlossiness\" (converted to "
            "metallic-roughness)");
}

TEST(SpecularGlossiness, TexturesAreConvertedPerTexel) {
  GltfBuilder builder = with_material({});
  // Black diffuse, half transparent; specular (sRGB) 255, 188, 0 with a glossiness of 0.2.
  const size_t diffuse = add_texture(builder, 1, 4, 0x80000000);
  const size_t specular = add_texture(builder, 2, 2, 0x3300bcff);
  builder.root["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {
      {"diffuseTexture", {{"index", diffuse}, {"texCoord", 1}}},
      {"specularGlossinessTexture", {{"index", specular}, {"texCoord", 1}}}};
  const Scene scene = loaded(builder);
  const Material& material = scene.materials[1];
  EXPECT_EQ(material.base_color, glm::vec4(1));
  EXPECT_EQ(material.metallic, 1);
  EXPECT_EQ(material.roughness, 1);
  EXPECT_EQ(material.base_color_texture.uv_set, 1u);
  EXPECT_EQ(material.metallic_roughness_texture.uv_set, 1u);
  EXPECT_TRUE(scene.textures[material.base_color_texture.texture].srgb);
  EXPECT_FALSE(scene.textures[material.metallic_roughness_texture.texture].srgb);
  EXPECT_EQ(first_texel(scene, material.base_color_texture), glm::ivec4(255, 188, 0, 128));
  EXPECT_EQ(first_texel(scene, material.metallic_roughness_texture), glm::ivec4(255, 204, 255, 255));
  const Image& made = scene.images[scene.textures[material.base_color_texture.texture].image];
  EXPECT_EQ(made.width, 2u);
  EXPECT_EQ(made.height, 4u);
}

TEST(SpecularGlossiness, PlasticKeepsDiffuseTexture) {
  GltfBuilder builder = with_material({{"diffuseTexture", {{"index", 0}}},
                                       {"specularFactor", {0, 0, 0}},
                                       {"diffuseFactor", {0.48, 0.48, 0.48, 1}}});
  const Scene scene = loaded(builder);
  const Material& material = scene.materials[1];
  EXPECT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0].width, 2u);
  EXPECT_NEAR(material.base_color.r, 0.5f, 1e-4f);  // without the dielectric's reflection of 0.04
  EXPECT_EQ(material.metallic, 0);
}

TEST(SpecularGlossiness, OtherCoordinatesAreNotCombined) {
  GltfBuilder builder = with_material({});
  const size_t specular = add_texture(builder, 2, 2, 0x33bc00ff);
  builder.root["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = {
      {"diffuseTexture", {{"index", 0}}},
      {"specularGlossinessTexture", {{"index", specular}, {"texCoord", 1}}},
      {"specularFactor", {0.5, 0.5, 0.5}}};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.images.size(), 2u);
  EXPECT_EQ(scene.materials[1].metallic_roughness_texture.texture, kNone);
  EXPECT_EQ(scene.textures[scene.materials[1].base_color_texture.texture].image, 0u);
}

TEST(SpecularGlossiness, LimitsAndFaults) {
  GltfBuilder builder = with_material({{"specularGlossinessTexture", {{"index", 0}}}});
  LoadLimits limits;
  limits.reserve = [](uint64_t bytes) -> Result<void> {
    if (bytes == 2 * 2 * 8) return Error{"no room"};
    return {};
  };
  const auto scene = load_glb(builder.glb(), "file", limits);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("no room"), std::string::npos) << scene.error().message;
  for (const auto& [factors, text] :
       {std::pair<json, const char*>{{{"specularFactor", 0.5}}, "specularFactor does not hold three numbers"},
        {{{"diffuseFactor", {1, 1, 1}}}, "diffuseFactor does not hold four numbers"},
        {{{"diffuseTexture", {{"index", 9}}}}, "textures[9]"}}) {
    const auto faulty = load(with_material(factors));
    ASSERT_FALSE(faulty.ok()) << text;
    EXPECT_NE(faulty.error().message.find(text), std::string::npos) << faulty.error().message;
  }
}

}  // namespace
}  // namespace fire3dv::scene
