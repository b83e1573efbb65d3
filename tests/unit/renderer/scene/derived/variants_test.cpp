// Test of material variants (KHR_materials_variants): reading, choice, validation and faults.
#include <gtest/gtest.h>

#include "renderer/scene/derived/variants.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

// Materials 0 to 3; variants "day", "night", "fog". Only the first primitive has mappings.
GltfBuilder with_variants() {
  GltfBuilder builder = test::triangle_file();
  builder.root["materials"] = {{{"name", "grey"}},
                               {{"name", "bright"}},
                               {{"name", "dark"}, {"alphaMode", "BLEND"}},
                               {{"name", "other"}}};
  builder.root["extensions"]["KHR_materials_variants"]["variants"] = {
      {{"name", "day"}, {"extras", {{"hour", 12}}}}, {{"name", "night"}}, {{"name", "fog"}}};
  json& primitives = builder.root["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = 0;
  primitives[1]["material"] = 3;
  primitives[0]["extensions"]["KHR_materials_variants"]["mappings"] = {
      {{"material", 1}, {"variants", {0}}, {"name", "bright"}}, {{"material", 2}, {"variants", {1}}}};
  builder.root["extensionsUsed"] = {"KHR_materials_variants"};
  builder.root["extensionsRequired"] = {"KHR_materials_variants"};
  return builder;
}

std::string first_material(const LoadedScene& loaded) {
  return loaded.scene.materials[loaded.scene.primitives[0].material].name;
}

TEST(SceneVariants, ChoiceAndReturn) {
  Scene scene = loaded(with_variants());
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.variants, (std::vector<std::string>{"day", "night", "fog"}));
  EXPECT_TRUE(check_scene(scene).ok());
  Derived derived = derive(scene, Levels::none);
  LoadedScene loaded{std::move(scene), std::move(derived)};
  EXPECT_EQ(first_material(loaded), "grey");
  for (const auto& [name, material] :
       {std::pair("night", "dark"), {"day", "bright"}, {"fog", "grey"}, {"night", "dark"}}) {
    const auto variant = find_variant(loaded.scene, name);
    ASSERT_TRUE(variant.ok());
    select_variant(loaded, *variant);
    EXPECT_EQ(first_material(loaded), material);
    EXPECT_EQ(loaded.scene.primitives[1].material, 4u);
  }
  select_variant(loaded, kNone);
  EXPECT_EQ(first_material(loaded), "grey");
}

// A blended material makes a planar caster open.
TEST(SceneVariants, ShadowCastersFollowTheMaterials) {
  Scene scene = loaded(with_variants());
  Derived derived = derive(scene, Levels::none);
  LoadedScene loaded{std::move(scene), std::move(derived)};
  EXPECT_EQ(loaded.derived.casters[0].shape, CasterShape::planar);
  select_variant(loaded, 1);
  EXPECT_EQ(loaded.derived.casters[0].shape, CasterShape::open);
  select_variant(loaded, kNone);
  EXPECT_EQ(loaded.derived.casters[0].shape, CasterShape::planar);
}

TEST(SceneVariants, UnknownNamesListKnownOnes) {
  const Scene scene = loaded(with_variants());
  const auto unknown = find_variant(scene, "dawn");
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(unknown.error().message,
            "there is no material variant \"dawn\"; there are \"day\", \"fog\", \"night\"");
  const auto none = find_variant(loaded(test::triangle_file()), "day");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().message, "there is no material variant \"day\": the file has none");
}

// All variants share the vertices.
TEST(SceneVariants, VariantNormalMapNeedsTangents) {
  GltfBuilder builder = with_variants();
  const auto image = test::png(1, 1, 0xffff8080);
  builder.root["images"] = {{{"bufferView", builder.add_view(image)}, {"mimeType", "image/png"}}};
  builder.root["textures"] = {{{"source", 0}}};
  json& primitive = builder.root["meshes"][0]["primitives"][0];
  builder.root["meshes"][0]["primitives"].erase(1);
  primitive["attributes"]["NORMAL"] = builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
  primitive["attributes"]["TEXCOORD_0"] =
      builder.add_data<float>({0, 0, 0, 1, 1, 0}, "VEC2", test::kFloat, 2);
  EXPECT_TRUE(loaded(builder).tangents.empty());
  builder.root["materials"][1]["normalTexture"] = {{"index", 0}};
  EXPECT_EQ(loaded(builder).tangents.size(), 3u);
}

TEST(SceneVariants, ValidationOfCachedScenes) {
  Scene scene = loaded(with_variants());
  const uint32_t right = scene.variant_materials[1];
  scene.variant_materials[1] = static_cast<uint32_t>(scene.materials.size());
  EXPECT_FALSE(check_scene(scene).ok());
  scene.variant_materials[1] = right;
  EXPECT_TRUE(check_scene(scene).ok());
  scene.variants.push_back("one more");
  EXPECT_FALSE(check_scene(scene).ok());
}

TEST(SceneVariants, FaultsByName) {
  const auto expect_error = [](const char* text, const auto& edit) {
    GltfBuilder builder = with_variants();
    edit(builder.root["extensions"]["KHR_materials_variants"]["variants"],
         builder.root["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"]);
    const auto scene = load(builder);
    ASSERT_FALSE(scene.ok()) << text;
    EXPECT_NE(scene.error().message.find(text), std::string::npos) << scene.error().message;
  };
  expect_error("mappings[0] refers to materials[9], but there are 4",
               [](json&, json& mappings) { mappings[0]["material"] = 9; });
  expect_error("mappings[1].variants refers to variants[3], but there are 3",
               [](json&, json& mappings) { mappings[1]["variants"] = {3}; });
  expect_error("mappings[0]: material is missing",
               [](json&, json& mappings) { mappings[0].erase("material"); });
  expect_error("mappings[0]: variants is missing",
               [](json&, json& mappings) { mappings[0].erase("variants"); });
  expect_error("mappings is not of the type", [](json&, json& mappings) { mappings = 5; });
  expect_error("variants[1]: name is missing", [](json& variants, json&) { variants[1].erase("name"); });
  expect_error("variants[1]: name is missing", [](json& variants, json&) { variants[1]["name"] = 7; });
  expect_error("variants is not of the type", [](json& variants, json&) { variants = "day"; });
}

}  // namespace
}  // namespace fire3dv::scene
