// Test of glTF loading: hierarchy, paths, transforms, lights, cameras, and large scenes.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

const Node* node_named(const Scene& scene, const std::string& name) {
  for (const Node& node : scene.nodes) {
    if (node.name == name) return &node;
  }
  return nullptr;
}

TEST(SceneLoad, TriangleInABinaryFile) {
  const Scene scene = loaded(test::triangle_file());
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "triangle");
  EXPECT_EQ(scene.nodes[0].mesh, 0u);
  ASSERT_EQ(scene.primitives.size(), 1u);
  EXPECT_EQ(scene.primitives[0].index_count, 3u);
  EXPECT_EQ(scene.primitives[0].material, 0u);
  EXPECT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.bounds_max, glm::vec3(1, 1, 0));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneLoad, AllContainersAreEqual) {
  const GltfBuilder builder = test::triangle_file();
  const test::ScratchFolder folder;
  folder.write("sub/my buffer.bin", builder.bin);
  for (const std::string& uri : {test::data_uri(builder.bin), std::string("sub/my%20buffer.bin")}) {
    auto scene = load_gltf(folder.write("scene.gltf", builder.gltf(uri)));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ASSERT_EQ(scene->positions.size(), 3u);
    EXPECT_EQ(scene->positions[1], glm::vec3(1, 0, 0));
  }
}

TEST(SceneLoad, ParentsPrecedeChildren) {
  GltfBuilder builder;
  builder.root["nodes"] = json::array({{{"name", "leaf"}, {"translation", {0, 0, 3}}},
                                       {{"name", "a/b~c"}, {"children", {0}}, {"translation", {0, 2, 0}}},
                                       {{"name", "root"}, {"children", {1}}, {"translation", {1, 0, 0}}}});
  builder.root["scenes"][0]["nodes"] = {2};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.nodes.size(), 3u);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(scene.nodes[i].parent == kNone || scene.nodes[i].parent < i);
  }
  const Node* leaf = node_named(scene, "leaf");
  ASSERT_TRUE(leaf);
  EXPECT_EQ(leaf->path, "root/a~1b~0c/leaf");
  EXPECT_EQ(glm::vec3(leaf->world_from_node[3]), glm::vec3(1, 2, 3));
}

TEST(SceneLoad, PartsAndMatrixAgree) {
  GltfBuilder builder;
  const double half = 0.70710678118654752;  // a quarter turn about Z, not exactly normalised
  builder.add_node(
      "parts",
      {{"translation", {1, 2, 3}}, {"rotation", {0, 0, half * 1.001, half * 1.001}}, {"scale", {2, 3, 4}}});
  builder.add_node("matrix", {{"matrix", {0, 2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1}}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.nodes.size(), 2u);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      EXPECT_NEAR(scene.nodes[0].parent_from_node[column][row], scene.nodes[1].parent_from_node[column][row],
                  1e-6);
    }
  }
  EXPECT_EQ(scene.nodes[1].parent_from_node[0][1], 2);
}

TEST(SceneLoad, DefaultSceneOrAllRoots) {
  GltfBuilder builder;
  builder.add_node("first");
  builder.root["nodes"].push_back({{"name", "second"}});
  builder.root["scenes"].push_back({{"nodes", {1}}});
  builder.root["scene"] = 1;
  Scene scene = loaded(builder);
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].name, "second");
  builder.root.erase("scenes");
  builder.root.erase("scene");
  EXPECT_EQ(loaded(builder).nodes.size(), 2u);
}

TEST(SceneLoad, ListedChildAppearsOnce) {
  GltfBuilder builder;
  const size_t parent = builder.add_node("parent");
  const size_t child = builder.add_child(parent, "child");
  builder.root["scenes"][0]["nodes"] = {child, parent};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.nodes.size(), 2u);
  EXPECT_EQ(node_named(scene, "child")->path, "parent/child");
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("nodes[1]"), std::string::npos);
}

TEST(SceneLoad, LightsAndCameras) {
  GltfBuilder builder;
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  builder.root["extensionsRequired"] = {"KHR_lights_punctual"};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"color", {1, 0.5, 0.25}}, {"intensity", 3}},
      {{"type", "spot"}, {"range", 7}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}};
  builder.root["cameras"] = {
      {{"type", "perspective"}, {"name", "front"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}}};
  builder.add_node("sun", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.add_node("lamp", {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"camera", 0}});
  builder.add_node("above", {{"camera", 1}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].type, LightType::directional);
  EXPECT_EQ(scene.lights[0].color, glm::vec3(1, 0.5, 0.25));
  EXPECT_EQ(scene.lights[1].type, LightType::spot);
  EXPECT_EQ(scene.lights[1].range_m, 7);
  EXPECT_EQ(scene.lights[1].outer_cone_rad, 0.5f);
  EXPECT_EQ(scene.nodes[1].light, 1u);
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].far_m, 0);
  EXPECT_EQ(scene.cameras[0].aspect, 0);
  EXPECT_TRUE(scene.cameras[1].orthographic);
  EXPECT_EQ(scene.cameras[1].half_extent_m, glm::vec2(2, 3));
  EXPECT_EQ(camera_nodes(scene), (std::vector<uint32_t>{1, 2}));
}

TEST(SceneLoad, UnknownLightsAreDark) {
  test::GltfBuilder builder = test::triangle_file();
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "laser"}, {"intensity", 5}}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].intensity, 0);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("the unknown type \"laser\""), std::string::npos) << scene.warnings[0];
}

TEST(SceneLoad, ValuesWithoutUseAreNoRefusal) {
  GltfBuilder builder = test::triangle_file();
  builder.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 4}, {"znear", 0.1}}}}};
  json& accessors = builder.root["accessors"];
  const size_t first = accessors.size();
  accessors.push_back({{"componentType", 5126}, {"count", 3}, {"type", "NO_VEC3"}});
  accessors.push_back({{"componentType", 5126}, {"count", 2}, {"type", "SCALAR"}});
  accessors.push_back({{"componentType", 5126}, {"count", 2}, {"type", "VEC3"}});
  accessors.push_back({{"componentType", 5126}, {"count", 1}, {"type", "MAT4"}});
  builder.root["animations"] = {
      {{"samplers", {{{"input", first + 1}, {"output", first + 2}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  builder.root["skins"] = {{{"joints", {0}}, {"inverseBindMatrices", first + 3}}};
  const Scene scene = loaded(builder);
  EXPECT_NEAR(scene.cameras.at(0).vertical_fov_rad, 3.1f, 1e-6f);
  EXPECT_EQ(scene.joints.at(0).joint_from_mesh, glm::mat4(1));
  EXPECT_TRUE(scene.channels.empty());
  std::string warnings;
  for (const std::string& warning : scene.warnings) warnings += warning + "\n";
  for (const char* part : {"yfov is not below pi", "the unknown type \"NO_VEC3\"", "without key times",
                           "inverseBindMatrices has no data"})
    EXPECT_NE(warnings.find(part), std::string::npos) << part << " in " << warnings;

  builder.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = first;
  EXPECT_FALSE(load(builder).ok());
}

TEST(SceneLoad, UnusedPartsAreReported) {
  GltfBuilder builder = test::triangle_file();
  builder.root["extensionsUsed"] = {"EXT_unheard_of"};
  builder.root["extras"] = {{"mesh", "anything"}};
  builder.root["nodes"][0]["extensions"] = {{"EXT_unheard_of", {{"mesh", "anything"}}}};
  builder.root["animations"] = {{{"channels", json::array()}}};
  builder.root["skins"] = {{{"joints", {0}}}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("EXT_unheard_of"), std::string::npos);
}

TEST(SceneLoad, LargeSceneLoads) {
  GltfBuilder builder;
  const size_t mesh = builder.add_triangle_mesh();
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  for (int i = 0; i < 64; ++i) {
    builder.root["extensions"]["KHR_lights_punctual"]["lights"].push_back(
        {{"type", "point"}, {"intensity", i}});
    builder.add_node("light " + std::to_string(i),
                     {{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  }
  // Half of the nodes are siblings, half form one long chain.
  for (int i = 0; i < 5000; ++i) builder.add_node("flat " + std::to_string(i), {{"mesh", mesh}});
  size_t parent = builder.add_node("chain 0", {{"translation", {0, 0, 1}}});
  for (int i = 1; i < 5000; ++i)
    parent = builder.add_child(parent, "chain " + std::to_string(i), {{"translation", {0, 0, 1}}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.nodes.size(), 10064u);
  EXPECT_EQ(scene.lights.size(), 64u);
  EXPECT_EQ(scene.lights[63].intensity, 63);
  EXPECT_EQ(scene.positions.size(), 3u);
  EXPECT_EQ(node_named(scene, "chain 4999")->world_from_node[3].z, 5000);
}

TEST(SceneLoad, ProgressCountsUpToWhole) {
  GltfBuilder builder = test::triangle_file();
  builder.root["meshes"][0]["primitives"][0]["material"] =
      builder.add_textured_material(test::png(2, 2, 0xffffffff));
  const test::ScratchFolder folder;
  size_t meshes = 0, images = 0;
  const auto scene = load_gltf(folder.write("scene.glb", builder.glb()), {},
                               [&](const char* stage, size_t done, size_t total) {
                                 EXPECT_LE(done, total);
                                 if (std::string_view(stage) == "meshes" && done == total) ++meshes;
                                 if (std::string_view(stage) == "images" && done == total) ++images;
                               });
  ASSERT_TRUE(scene.ok());
  EXPECT_GE(meshes, 1u);
  EXPECT_GE(images, 1u);
}

}  // namespace
}  // namespace fire3dv::scene
