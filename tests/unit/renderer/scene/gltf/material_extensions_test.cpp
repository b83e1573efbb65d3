// Test of KHR_materials_* extensions, and of light radii.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

bool warned(const Scene& scene, const std::string& text) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
}

GltfBuilder with_extensions(json extensions) {
  GltfBuilder builder;
  builder.add_textured_material(test::png(1, 1, 0xffffffff));
  builder.root["materials"][0]["extensions"] = std::move(extensions);
  return builder;
}

// A textureInfo with a unique transform.
json texture(double offset) {
  return {
      {"index", 0}, {"texCoord", 1}, {"extensions", {{"KHR_texture_transform", {{"offset", {offset, 0}}}}}}};
}

void expect_texture(const Scene& scene, const TextureRef& ref, float offset, bool srgb) {
  ASSERT_LT(ref.texture, scene.textures.size());
  EXPECT_EQ(scene.textures[ref.texture].srgb, srgb) << offset;
  EXPECT_EQ(ref.uv_offset.x, offset);
  EXPECT_EQ(ref.uv_set, 1u);
}

TEST(SceneMaterialExtensions, EveryMemberIsRead) {
  GltfBuilder builder = with_extensions(
      {{"KHR_materials_ior", {{"ior", 1.33}}},
       {"KHR_materials_specular",
        {{"specularFactor", 0.25},
         {"specularColorFactor", {0.5, 2, 3}},
         {"specularTexture", texture(1)},
         {"specularColorTexture", texture(2)}}},
       {"KHR_materials_clearcoat",
        {{"clearcoatFactor", 0.75},
         {"clearcoatRoughnessFactor", 0.125},
         {"clearcoatTexture", texture(3)},
         {"clearcoatRoughnessTexture", texture(4)},
         {"clearcoatNormalTexture", texture(5)}}},
       {"KHR_materials_sheen",
        {{"sheenColorFactor", {0.25, 0.5, 1}},
         {"sheenRoughnessFactor", 0.375},
         {"sheenColorTexture", texture(6)},
         {"sheenRoughnessTexture", texture(7)}}},
       {"KHR_materials_anisotropy",
        {{"anisotropyStrength", 0.625}, {"anisotropyRotation", -7.5}, {"anisotropyTexture", texture(9)}}},
       {"KHR_materials_iridescence",
        {{"iridescenceFactor", 0.5},
         {"iridescenceIor", 1.75},
         {"iridescenceThicknessMinimum", 650},
         {"iridescenceThicknessMaximum", 250},
         {"iridescenceTexture", texture(12)},
         {"iridescenceThicknessTexture", texture(13)}}},
       {"KHR_materials_transmission", {{"transmissionFactor", 0.875}, {"transmissionTexture", texture(8)}}},
       {"KHR_materials_volume",
        {{"thicknessFactor", 2},
         {"thicknessTexture", texture(9)},
         {"attenuationDistance", 0.25},
         {"attenuationColor", {0.5, 0.25, 1}}}},
       {"KHR_materials_dispersion", {{"dispersion", 0.375}}},
       {"KHR_materials_diffuse_transmission",
        {{"diffuseTransmissionFactor", 0.625},
         {"diffuseTransmissionTexture", texture(10)},
         {"diffuseTransmissionColorFactor", {0.75, 0.5, 0}},
         {"diffuseTransmissionColorTexture", texture(11)}}}});
  builder.root["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]["scale"] =
      0.5;
  builder.root["extensionsRequired"] = {"KHR_materials_ior",          "KHR_materials_specular",
                                        "KHR_materials_clearcoat",    "KHR_materials_sheen",
                                        "KHR_materials_transmission", "KHR_materials_volume",
                                        "KHR_materials_dispersion",   "KHR_materials_diffuse_transmission",
                                        "KHR_materials_anisotropy",   "KHR_materials_iridescence"};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(warned(scene, "approximated: \"KHR_materials_transmission\""));
  for (const char* name : {"volume", "dispersion"})
    EXPECT_TRUE(warned(scene, ", \"KHR_materials_" + std::string(name) + "\" (")) << name;
  const Material& material = scene.materials[1];
  EXPECT_EQ(material.ior, 1.33f);
  EXPECT_EQ(material.specular, 0.25f);
  EXPECT_EQ(material.specular_color, glm::vec3(0.5, 2, 3));
  EXPECT_EQ(material.clearcoat, 0.75f);
  EXPECT_EQ(material.clearcoat_roughness, 0.125f);
  EXPECT_EQ(material.clearcoat_normal_scale, 0.5f);
  EXPECT_EQ(material.sheen_color, glm::vec3(0.25, 0.5, 1));
  EXPECT_EQ(material.sheen_roughness, 0.375f);
  EXPECT_EQ(material.anisotropy, 0.625f);
  EXPECT_EQ(material.anisotropy_rotation_rad, -7.5f);
  EXPECT_EQ(material.iridescence, 0.5f);
  EXPECT_EQ(material.iridescence_ior, 1.75f);
  EXPECT_EQ(material.iridescence_thickness_min_nm, 650);  // may exceed the maximum
  EXPECT_EQ(material.iridescence_thickness_max_nm, 250);
  EXPECT_EQ(material.transmission, 0.875f);
  expect_texture(scene, material.specular_texture, 1, false);
  expect_texture(scene, material.specular_color_texture, 2, true);
  expect_texture(scene, material.clearcoat_texture, 3, false);
  expect_texture(scene, material.clearcoat_roughness_texture, 4, false);
  expect_texture(scene, material.clearcoat_normal_texture, 5, false);
  expect_texture(scene, material.sheen_color_texture, 6, true);
  expect_texture(scene, material.sheen_roughness_texture, 7, false);
  expect_texture(scene, material.transmission_texture, 8, false);
  expect_texture(scene, material.anisotropy_texture, 9, false);
  EXPECT_EQ(material.thickness, 2);
  EXPECT_EQ(material.attenuation_distance_m, 0.25f);
  EXPECT_EQ(material.attenuation_color, glm::vec3(0.5f, 0.25f, 1));
  EXPECT_EQ(material.dispersion, 0.375f);
  EXPECT_EQ(material.diffuse_transmission, 0.625f);
  EXPECT_EQ(material.diffuse_transmission_color, glm::vec3(0.75f, 0.5f, 0));
  expect_texture(scene, material.diffuse_transmission_texture, 10, false);
  expect_texture(scene, material.diffuse_transmission_color_texture, 11, true);
  expect_texture(scene, material.iridescence_texture, 12, false);
  expect_texture(scene, material.iridescence_thickness_texture, 13, false);
}

// Rays measure the thickness, so that its texture has no effect and its image is not loaded.
TEST(SceneMaterialExtensions, ThicknessTexturesAreOnlyChecked) {
  const Scene scene = loaded(with_extensions(
      {{"KHR_materials_volume", {{"thicknessFactor", 0.5}, {"thicknessTexture", {{"index", 0}}}}}}));
  EXPECT_EQ(scene.materials[1].thickness, 0.5f);
  EXPECT_EQ(scene.textures.size(), 1u) << "that of the base colour";
}

TEST(SceneMaterialExtensions, EmptyOnesChangeNothing) {
  const json none = json::object();
  const Scene scene = loaded(with_extensions({{"KHR_materials_ior", none},
                                              {"KHR_materials_specular", none},
                                              {"KHR_materials_clearcoat", none},
                                              {"KHR_materials_sheen", none},
                                              {"KHR_materials_anisotropy", none},
                                              {"KHR_materials_iridescence", none},
                                              {"KHR_materials_transmission", none},
                                              {"KHR_materials_volume", none},
                                              {"KHR_materials_dispersion", none},
                                              {"KHR_materials_diffuse_transmission", none}}));
  const Material& material = scene.materials[1];
  EXPECT_EQ(material.ior, 1.5f);
  EXPECT_EQ(material.specular, 1);
  EXPECT_EQ(material.specular_color, glm::vec3(1));
  EXPECT_EQ(material.clearcoat, 0);
  EXPECT_EQ(material.clearcoat_normal_scale, 1);
  EXPECT_EQ(material.sheen_color, glm::vec3(0));
  EXPECT_EQ(material.anisotropy, 0);
  EXPECT_EQ(material.iridescence, 0);
  EXPECT_EQ(material.iridescence_ior, 1.3f);
  EXPECT_EQ(material.iridescence_thickness_min_nm, 100);
  EXPECT_EQ(material.iridescence_thickness_max_nm, 400);
  EXPECT_EQ(material.transmission, 0);
  EXPECT_EQ(material.thickness, 0);
  EXPECT_EQ(material.attenuation_distance_m, 0);  // infinite
  EXPECT_EQ(material.attenuation_color, glm::vec3(1));
  EXPECT_EQ(material.dispersion, 0);
  EXPECT_EQ(material.diffuse_transmission, 0);
  EXPECT_EQ(material.diffuse_transmission_color, glm::vec3(1));
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(material.clearcoat_normal_texture.texture, kNone);
}

TEST(SceneMaterialExtensions, FactorsAreClamped) {
  const Scene scene = loaded(with_extensions(
      {{"KHR_materials_ior", {{"ior", 0.5}}},
       {"KHR_materials_specular", {{"specularFactor", -1}, {"specularColorFactor", {-2, 5, 0}}}},
       {"KHR_materials_clearcoat", {{"clearcoatFactor", 1e30}, {"clearcoatRoughnessFactor", 2}}},
       {"KHR_materials_sheen", {{"sheenColorFactor", {2, 0, 0}}, {"sheenRoughnessFactor", -0.5}}},
       {"KHR_materials_anisotropy", {{"anisotropyStrength", 1.5}}},
       {"KHR_materials_iridescence",
        {{"iridescenceIor", 0.9},
         {"iridescenceThicknessMinimum", -5},
         {"iridescenceThicknessMaximum", 1e30}}},
       {"KHR_materials_transmission", {{"transmissionFactor", 7}}},
       {"KHR_materials_volume",
        {{"thicknessFactor", -1}, {"attenuationDistance", 0}, {"attenuationColor", {-1, 0, 0}}}},
       {"KHR_materials_dispersion", {{"dispersion", -2}}},
       {"KHR_materials_diffuse_transmission",
        {{"diffuseTransmissionFactor", 3}, {"diffuseTransmissionColorFactor", {0, 0, -1}}}},
       {"KHR_materials_emissive_strength", {{"emissiveStrength", -3}}}}));
  const Material& material = scene.materials[1];
  EXPECT_EQ(material.ior, 1);
  EXPECT_EQ(material.specular, 0);
  EXPECT_EQ(material.specular_color, glm::vec3(0, 5, 0));
  EXPECT_EQ(material.clearcoat, 1);
  EXPECT_EQ(material.clearcoat_roughness, 1);
  EXPECT_EQ(material.sheen_color, glm::vec3(1, 0, 0));
  EXPECT_EQ(material.sheen_roughness, 0);
  EXPECT_EQ(material.transmission, 1);
  EXPECT_EQ(material.anisotropy, 1);
  EXPECT_EQ(material.iridescence_ior, 1);
  EXPECT_EQ(material.iridescence_thickness_min_nm, 0);
  EXPECT_EQ(material.iridescence_thickness_max_nm, 1e6f);
  EXPECT_EQ(material.thickness, 0);
  EXPECT_GT(material.attenuation_distance_m, 0);
  EXPECT_EQ(material.attenuation_color, glm::vec3(0));
  EXPECT_EQ(material.dispersion, 0);
  EXPECT_EQ(material.diffuse_transmission, 1);
  EXPECT_EQ(material.diffuse_transmission_color, glm::vec3(0));
  EXPECT_EQ(scene.warnings.size(), 20u);  // the last: approximations
  EXPECT_TRUE(
      warned(scene, "materials[0].extensions.KHR_materials_transmission.transmissionFactor is more than 1"));
  EXPECT_TRUE(warned(scene, "KHR_materials_ior.ior is less than 1"));
}

TEST(SceneMaterialExtensions, ZeroIorStays) {
  const Scene scene = loaded(with_extensions({{"KHR_materials_ior", {{"ior", 0}}}}));
  EXPECT_EQ(scene.materials[1].ior, 0);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneMaterialExtensions, FaultsByName) {
  const std::vector<std::pair<json, std::string>> faults{
      {{{"KHR_materials_ior", {{"ior", "glass"}}}}, "ior is not of the type"},
      {{{"KHR_materials_sheen", {{"sheenColorFactor", {1, 2}}}}},
       "sheenColorFactor does not hold three numbers"},
      {{{"KHR_materials_specular", {{"specularColorFactor", 1}}}}, "specularColorFactor is not of the type"},
      {{{"KHR_materials_clearcoat", {{"clearcoatTexture", {{"texCoord", 1}}}}}},
       "clearcoatTexture: index is missing"},
      {{{"KHR_materials_transmission", {{"transmissionTexture", {{"index", 9}}}}}},
       "textures[9], but there are 1"},
      {{{"KHR_materials_volume", {{"attenuationColor", {1, 2}}}}},
       "attenuationColor does not hold three numbers"},
      {{{"KHR_materials_volume", {{"thicknessFactor", "thick"}}}}, "thicknessFactor is not of the type"},
      {{{"KHR_materials_volume", {{"thicknessTexture", {{"index", 3}}}}}},
       "thicknessTexture refers to textures[3], but there are 1"},
      {{{"KHR_materials_volume", {{"thicknessTexture", 0}}}}, "thicknessTexture is not of the type"},
      {{{"KHR_materials_volume", {{"thicknessTexture", {{"texCoord", 1}}}}}},
       "thicknessTexture: index is missing"},
      {{{"KHR_materials_dispersion", {{"dispersion", {1}}}}}, "dispersion is not of the type"},
      {{{"KHR_materials_diffuse_transmission", {{"diffuseTransmissionTexture", {{"index", 9}}}}}},
       "textures[9], but there are 1"},
      {{{"KHR_materials_anisotropy", {{"anisotropyRotation", {1, 0}}}}},
       "anisotropyRotation is not of the type"},
      {{{"KHR_materials_anisotropy", {{"anisotropyTexture", {{"index", 4}}}}}},
       "textures[4], but there are 1"},
      {{{"KHR_materials_iridescence", {{"iridescenceIor", "oil"}}}}, "iridescenceIor is not of the type"},
      {{{"KHR_materials_iridescence", {{"iridescenceThicknessTexture", {{"index", 7}}}}}},
       "textures[7], but there are 1"},
      {{{"KHR_materials_sheen", {{"sheenColorTexture", {{"index", -1}}}}}}, "index is not of the type"}};
  for (const auto& [extensions, text] : faults) {
    const auto scene = load(with_extensions(extensions));
    ASSERT_FALSE(scene.ok()) << text;
    EXPECT_NE(scene.error().message.find(text), std::string::npos) << scene.error().message;
  }
}

// Triangles without tangents and texture coordinates have no direction.
TEST(SceneMaterialExtensions, DirectionlessAnisotropyIsReported) {
  for (const bool has_coordinates : {false, true}) {
    GltfBuilder builder = with_extensions({{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}}}});
    json attributes{{"POSITION", builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}};
    if (has_coordinates)
      attributes["TEXCOORD_0"] = builder.add_data<float>({0, 0, 0, 1, 1, 0}, "VEC2", test::kFloat, 2);
    builder.add_mesh({{"attributes", attributes}, {"material", 0}});
    EXPECT_EQ(warned(loaded(builder), "meshes[0].primitives[0] has an anisotropic material, but neither"),
              !has_coordinates);
  }
}

TEST(SceneLights, RadiiFromExtras) {
  GltfBuilder builder;
  const auto light = [](const char* type, json extras) {
    return json{{"type", type}, {"extras", std::move(extras)}};
  };
  json spot = light("spot", {{"radius", 1}, {"comment", {{"radius", 3}}}});
  spot["spot"] = json::object();
  spot["extras"]["spread"] = 3;  // a cone has none
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      light("point", {{"radius", 0.25}, {"spread", 2.5}}),
      spot,
      light("directional", {{"angular_radius", 0.005}}),
      light("directional", {{"angle", 0.01}}),
      light("point", {{"radius", "large"}}),
      light("point", "text"),
      light("point", {{"radius", -1}}),
      light("directional", {{"radius", 5}})};
  builder.add_node("keeps the file from being empty");
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.lights.size(), 8u);
  EXPECT_EQ(scene.lights[0].radius_m, 0.25f);
  EXPECT_EQ(scene.lights[0].spread, 2.5f);
  EXPECT_EQ(scene.lights[1].radius_m, 1);
  EXPECT_EQ(scene.lights[1].spread, 0);
  EXPECT_EQ(scene.lights[2].angular_radius_rad, 0.005f);
  EXPECT_EQ(scene.lights[3].angular_radius_rad, 0.005f);
  EXPECT_EQ(scene.lights[4].radius_m, 0);  // extras are untyped
  EXPECT_EQ(scene.lights[5].radius_m, 0);
  EXPECT_EQ(scene.lights[6].radius_m, 0);
  EXPECT_TRUE(warned(scene, "lights[6].extras.radius is less than 0"));
  EXPECT_EQ(scene.lights[7].radius_m, 0);
  EXPECT_EQ(scene.lights[7].angular_radius_rad, 0);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(SceneCameras, LensFromExtras) {
  GltfBuilder builder;
  const auto camera = [](json extras) {
    return json{{"type", "perspective"},
                {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                {"extras", std::move(extras)}};
  };
  json orthographic = {{"type", "orthographic"},
                       {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}},
                       {"extras", {{"fNumber", 2}, {"focusDistanceM", 1}}}};
  builder.root["cameras"] = {camera({{"fNumber", 2.8}, {"focusDistanceM", 1.5}, {"comment", "tele"}}),
                             camera({{"fNumber", 2.8}}),
                             camera({{"fNumber", -1}, {"focusDistanceM", 1e9}}),
                             camera({{"fNumber", "wide"}, {"focusDistanceM", json::array({1})}}),
                             camera("text"),
                             orthographic};
  builder.add_node("keeps the file from being empty");
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.cameras.size(), 6u);
  EXPECT_EQ(scene.cameras[0].lens, (ThinLens{2.8f, 1.5f}));
  EXPECT_TRUE(scene.cameras[1].lens.is_pinhole());
  EXPECT_TRUE(warned(scene, "cameras[1].extras has only one of fNumber and focusDistanceM"));
  EXPECT_EQ(scene.cameras[2].lens, (ThinLens{kMinFNumber, kMaxFocusDistanceM}));
  EXPECT_TRUE(warned(scene, "cameras[2].extras.fNumber is less than 0.1"));
  EXPECT_TRUE(warned(scene, "cameras[2].extras.focusDistanceM is more than 1e+06"));
  for (const size_t pinhole : {3u, 4u, 5u}) EXPECT_EQ(scene.cameras[pinhole].lens, ThinLens()) << pinhole;
  EXPECT_EQ(scene.warnings.size(), 3u);
}

TEST(SceneCameras, IntrinsicsFromExtras) {
  GltfBuilder builder;
  const auto camera = [](json extras) {
    return json{{"type", "perspective"},
                {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                {"extras", std::move(extras)}};
  };
  builder.root["cameras"] = {camera({{"pixelAspectRatio", 0.5}, {"principalPoint", {0.25, -0.125}}}),
                             camera({{"pixelAspectRatio", 0}, {"principalPoint", {1e9, 0}}}),
                             camera({{"pixelAspectRatio", "wide"}, {"principalPoint", {1, "down"}}}),
                             camera({{"comment", "plain"}})};
  builder.add_node("keeps the file from being empty");
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.cameras.size(), 4u);
  EXPECT_EQ(scene.cameras[0].pixel_aspect, 0.5f);
  EXPECT_EQ(scene.cameras[0].principal_point, glm::vec2(0.25f, -0.125f));
  EXPECT_EQ(scene.cameras[1].pixel_aspect, kMinPixelAspect);
  EXPECT_EQ(scene.cameras[1].principal_point, glm::vec2(kMaxPrincipalPoint, 0));
  EXPECT_TRUE(warned(scene, "cameras[1].extras.pixelAspectRatio is less than 0.001"));
  EXPECT_TRUE(warned(scene, "cameras[1].extras.principalPoint is more than 1000"));
  EXPECT_TRUE(warned(scene, "cameras[2].extras.principalPoint is no list of two numbers"));
  for (const size_t plain : {2u, 3u}) {
    EXPECT_EQ(scene.cameras[plain].pixel_aspect, 1) << plain;
    EXPECT_EQ(scene.cameras[plain].principal_point, glm::vec2(0)) << plain;
  }
  EXPECT_EQ(scene.warnings.size(), 3u);
}

TEST(SceneExtras, SkyIsATexture) {
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(4, 2, 0x336699ff));
  builder.root["scenes"][0]["extras"]["skyTexture"] = 0;
  const Scene scene = loaded(builder);
  ASSERT_LT(scene.sky_texture, scene.textures.size());
  EXPECT_TRUE(scene.textures[scene.sky_texture].srgb);
  EXPECT_EQ(scene.images.at(scene.textures[scene.sky_texture].image).width, 4u);
  builder.root["scenes"][0]["extras"]["skyTexture"] = "blue";
  const Scene plain = loaded(builder);
  EXPECT_EQ(plain.sky_texture, kNone);
  EXPECT_TRUE(warned(plain, "scenes[0].extras.skyTexture is no index of a texture"));
  builder.root["scenes"][0]["extras"]["skyTexture"] = 7;
  const auto wrong = load(builder);
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().message.find("scenes[0].extras.skyTexture"), std::string::npos)
      << wrong.error().message;
}

TEST(SceneExtras, DefaultViewAndUnboundedMeshes) {
  GltfBuilder builder = test::triangle_file();
  builder.root["meshes"][0]["extras"]["unbounded"] = true;
  builder.root["scenes"][0]["extras"]["viewFrom"] = {2, 0, 0};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.view_from, glm::vec3(1, 0, 0));
  ASSERT_FALSE(scene.meshes.empty());
  EXPECT_TRUE(scene.meshes[0].unbounded);
  EXPECT_NE(scene.bounds_min, scene.bounds_max) << "there is nothing else";
  for (const json& wrong : {json({0, 0, 0}), json({1, 2}), json("front"), json({1e30, 0, 0})}) {
    builder.root["scenes"][0]["extras"]["viewFrom"] = wrong;
    const Scene usual = loaded(builder);
    EXPECT_EQ(usual.view_from, glm::vec3(0)) << wrong;
    EXPECT_TRUE(warned(usual, "scenes[0].extras.viewFrom is no direction of three numbers")) << wrong;
  }
}

}  // namespace
}  // namespace fire3dv::scene
