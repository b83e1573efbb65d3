// Test of EXT_mesh_gpu_instancing.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/state/node_index.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

// A triangle in a node "field" at (10, 0, 0), with these instancing attributes.
GltfBuilder field(GltfBuilder builder, json attributes) {
  builder.add_node("field",
                   {{"mesh", builder.add_triangle_mesh()},
                    {"translation", {10, 0, 0}},
                    {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", std::move(attributes)}}}}}});
  builder.root["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  return builder;
}

TEST(SceneInstancing, InstancesAreChildNodes) {
  GltfBuilder builder;
  const size_t translation = builder.add_positions({1, 0, 0, 0, 2, 0});
  const size_t rotation = builder.add_data<float>({0, 0, 0, 1, 0, 0, 1, 0}, "VEC4", test::kFloat, 4);
  const size_t scale = builder.add_positions({1, 1, 1, 2, 3, 4});
  builder = field(builder, {{"TRANSLATION", translation}, {"ROTATION", rotation}, {"SCALE", scale}});
  builder.add_child(0, "child");
  const auto scene = load(builder);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(scene->warnings.empty());
  ASSERT_EQ(scene->nodes.size(), 4u);
  EXPECT_EQ(scene->nodes[0].mesh, kNone);
  for (uint32_t i : {1u, 2u}) {
    EXPECT_EQ(scene->nodes[i].parent, 0u);
    EXPECT_EQ(scene->nodes[i].mesh, 0u);
  }
  EXPECT_EQ(scene->nodes[3].name, "child");
  EXPECT_EQ(scene->nodes[1].world_from_node, glm::translate(glm::mat4(1), glm::vec3(11, 0, 0)));
  // Half a turn about Z, after the scale.
  const glm::vec3 corner(scene->nodes[2].world_from_node * glm::vec4(1, 1, 1, 1));
  EXPECT_NEAR(glm::distance(corner, glm::vec3(8, -1, 4)), 0, 1e-5);
  EXPECT_EQ(scene->bounds_max.x, 12);
}

TEST(SceneInstancing, InstancesAreUnnamed) {
  GltfBuilder builder;
  const size_t translation = builder.add_positions({1, 0, 0, 0, 2, 0});
  builder = field(builder, {{"TRANSLATION", translation}});
  builder.add_child(0, "");  // already has the path "field/"
  const auto scene = load(builder);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const state::NodeNames names(*scene);
  EXPECT_EQ(names.find("field"), 0u);
  EXPECT_EQ(names.find("field/"), 3u);
}

TEST(SceneInstancing, RotationsOfEveryComponentType) {
  GltfBuilder builder;
  const size_t bytes = builder.add_data<int8_t>({0, 0, 90, 90}, "VEC4", test::kByte, 4, true);
  const size_t shorts = builder.add_data<int16_t>({0, 0, 23170, 23170}, "VEC4", test::kShort, 4, true);
  const size_t floats = builder.add_data<float>({0, 0, 0.70710678f, 0.70710678f}, "VEC4", test::kFloat, 4);
  for (const size_t rotation : {bytes, shorts, floats}) {
    const auto scene = load(field(builder, {{"ROTATION", rotation}}));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const glm::vec4 turned = scene->nodes.at(1).parent_from_node * glm::vec4(1, 0, 0, 1);
    EXPECT_NEAR(glm::distance(glm::vec3(turned), glm::vec3(0, 1, 0)), 0, 1e-6) << rotation;
  }
}

TEST(SceneInstancing, MeshlessNodeHasNone) {
  GltfBuilder builder;
  const size_t translation = builder.add_positions({1, 0, 0});
  builder.add_node(
      "empty",
      {{"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translation}}}}}}}});
  const auto scene = load(builder);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->nodes.size(), 1u);
}

TEST(SceneInstancing, FaultsByName) {
  GltfBuilder builder;
  const size_t two = builder.add_positions({0, 0, 0, 1, 1, 1});
  const size_t one = builder.add_positions({1, 1, 1});
  const size_t flat = builder.add_data<float>({1, 1}, "VEC2", test::kFloat, 2);
  const size_t zero = builder.add_data<float>({0, 0, 0, 0}, "VEC4", test::kFloat, 4);
  const size_t raw = builder.add_data<int8_t>({0, 0, 0, 127}, "VEC4", test::kByte, 4, false);
  const size_t packed = builder.add_data<int16_t>({1, 1, 1}, "VEC3", test::kShort, 3, true);
  const std::vector<std::pair<json, std::string>> faults{
      {json::object({{"_CUSTOM", one}}), "neither TRANSLATION nor ROTATION nor SCALE"},
      {{{"TRANSLATION", two}, {"SCALE", one}}, "SCALE has 1 elements, but another attribute has 2"},
      {{{"TRANSLATION", 99}}, "accessors[99], but there are"},
      {{{"TRANSLATION", flat}}, "TRANSLATION"},
      {{{"TRANSLATION", packed}},
       "componentType 5122, normalized, which EXT_mesh_gpu_instancing does not allow"},
      {{{"ROTATION", raw}}, "componentType 5120, not normalized"},
      {{{"ROTATION", zero}}, "ROTATION holds, at 0, no rotation"},
      {{{"SCALE", "large"}}, "attributes is not of the type"}};
  for (const auto& [attributes, text] : faults) {
    const auto scene = load(field(builder, attributes));
    ASSERT_FALSE(scene.ok()) << text;
    EXPECT_NE(scene.error().message.find(text), std::string::npos) << scene.error().message;
    EXPECT_NE(scene.error().message.find("nodes[0].extensions.EXT_mesh_gpu_instancing"), std::string::npos);
  }
}

TEST(SceneInstancing, InstanceCountIsBounded) {
  GltfBuilder builder;
  const size_t mesh = builder.add_triangle_mesh();
  // All zeros without data in the file; the loader allows up to a million such elements.
  builder.root["accessors"].push_back({{"count", 1000000}, {"type", "VEC3"}, {"componentType", 5126}});
  const size_t zeros = builder.root["accessors"].size() - 1;
  for (int i = 0; i < 2; ++i) {
    builder.add_node(
        "field", {{"mesh", mesh},
                  {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", zeros}}}}}}}});
  }
  const auto scene = load(builder);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("more than 1048576 instances"), std::string::npos)
      << scene.error().message;
}

}  // namespace
}  // namespace fire3dv::scene
