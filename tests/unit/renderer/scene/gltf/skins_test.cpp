// Test of the loaded layout of skins, influences and morph targets.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "renderer/scene/model/vertices.h"
#include "tests/unit/renderer/scene/gltf/motion_file.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

json& primitive(GltfBuilder& builder) {
  return builder.root["meshes"][0]["primitives"][0];
}

TEST(SceneSkins, JointsAndInverseBindMatrices) {
  const Scene scene = test::loaded_scene(test::motion_file());
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.skins.size(), 1u);
  EXPECT_EQ(scene.skins[0].name, "bones");
  EXPECT_EQ(scene.skins[0].joint_count, 2u);
  ASSERT_EQ(scene.joints.size(), 2u);
  EXPECT_EQ(scene.nodes[scene.joints[1].node].name, "tip");
  EXPECT_EQ(scene.joints[0].joint_from_mesh, glm::mat4(1));
  EXPECT_EQ(scene.joints[1].joint_from_mesh[3], glm::vec4(0, -1, 0, 1));
  EXPECT_EQ(scene.nodes[0].skin, 0u);
}

TEST(SceneSkins, JointsAreShownScenesNodes) {
  GltfBuilder builder = test::motion_file();
  builder.root["scenes"][0]["nodes"] = {1, 0};  // scene indices differ from file indices
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.joints.size(), 2u);
  EXPECT_EQ(scene.joints[0].node, 0u);
  EXPECT_EQ(scene.joints[1].node, 1u);
  EXPECT_EQ(scene.nodes[2].skin, 0u);
  builder.root["scenes"][0]["nodes"] = {0};
  const Scene without = test::loaded_scene(builder);
  EXPECT_EQ(without.nodes[0].skin, kNone);
  EXPECT_EQ(without.skins[0].joint_count, 0u);
  ASSERT_EQ(without.warnings.size(), 1u);
  EXPECT_NE(without.warnings[0].find("not part of the shown scene"), std::string::npos);
}

TEST(SceneSkins, MissingBindMatricesAreIdentity) {
  GltfBuilder builder = test::motion_file();
  builder.root["skins"][0].erase("inverseBindMatrices");
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.joints.size(), 2u);
  EXPECT_EQ(scene.joints[1].joint_from_mesh, glm::mat4(1));
}

TEST(SceneSkins, WeightsAreNormalized) {
  const Scene scene = test::loaded_scene(test::motion_file());
  const Primitive& primitive = scene.primitives[0];
  ASSERT_EQ(primitive.influence_sets, 1u);
  ASSERT_EQ(scene.influences.size(), 3u);
  EXPECT_EQ(primitive.joint_limit, 2u) << "joint 9 has no weight";
  const Influences& second = scene.influences[primitive.first_influence + 1];
  EXPECT_EQ(second.joints, (std::array<uint16_t, 4>{0, 1, 0, 0}));
  EXPECT_NEAR(second.weights[0], 0.2f, 1e-6f);
  EXPECT_NEAR(second.weights[1], 0.8f, 1e-6f);
  const Influences& third = scene.influences[primitive.first_influence + 2];
  EXPECT_EQ(third.joints, (std::array<uint16_t, 4>{1, 0, 0, 0}));
  EXPECT_EQ(third.weights[0], 1) << "200 of 255 was its whole weight";
}

TEST(SceneSkins, EightJointsOfAnyType) {
  GltfBuilder builder = test::motion_file();
  const size_t joints =
      builder.add_data<uint16_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", test::kUnsignedShort, 4);
  const size_t floats =
      builder.add_data<float>({0, 0, 0, 0, .5f, 0, 0, 0, 0, -1, 0, 0}, "VEC4", test::kFloat, 4);
  const size_t shorts = builder.add_data<uint16_t>({0, 0, 0, 0, 0, 65535, 0, 0, 0, 0, 0, 0}, "VEC4",
                                                   test::kUnsignedShort, 4, true);
  primitive(builder)["attributes"].update(
      {{"JOINTS_1", joints}, {"WEIGHTS_0", floats}, {"WEIGHTS_1", shorts}});
  const Scene scene = test::loaded_scene(builder);
  const Primitive& primitive = scene.primitives[0];
  ASSERT_EQ(primitive.influence_sets, 2u);
  const Influences* second = &scene.influences[primitive.first_influence + 2];
  EXPECT_NEAR(second[0].weights[0], 1.0f / 3, 1e-6f);
  EXPECT_NEAR(second[1].weights[1], 2.0f / 3, 1e-6f);
  EXPECT_EQ(second[1].joints[1], 1);
  const Influences* third = second + 2;
  EXPECT_EQ(third[0].joints[0], 1) << "no weight above 0: the first joint has it all";
  EXPECT_EQ(third[0].weights[0], 1);
  EXPECT_EQ(third[0].weights[1], 0);
}

TEST(SceneSkins, SparseWeights) {
  GltfBuilder builder = test::motion_file();
  const std::vector<uint8_t> index{2};
  const std::vector<uint8_t> value{0, 255, 0, 0};
  builder.root["accessors"][test::kJoints]["sparse"] = {
      {"count", 1},
      {"indices",
       {{"bufferView", builder.add_view(std::as_bytes(std::span(index)))}, {"componentType", 5121}}},
      {"values", {{"bufferView", builder.add_view(std::as_bytes(std::span(value)))}}}};
  builder.root["accessors"][test::kWeights]["sparse"] = builder.root["accessors"][test::kJoints]["sparse"];
  builder.root["skins"][0]["joints"] = json::array();
  for (int i = 0; i < 256; ++i) builder.root["skins"][0]["joints"].push_back(1 + i % 2);
  builder.root["skins"][0].erase("inverseBindMatrices");
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.influences.size(), 3u);
  EXPECT_EQ(scene.influences[2].joints[1], 255);
  EXPECT_EQ(scene.influences[2].weights[1], 1);
}

TEST(SceneSkins, SplitVerticesKeepInfluences) {
  GltfBuilder builder = test::motion_file();
  primitive(builder)["attributes"].erase("NORMAL");
  primitive(builder)["indices"] = builder.add_indices({2, 0, 1, 1, 0, 2});
  const Scene scene = test::loaded_scene(builder);
  const Primitive& primitive = scene.primitives[0];
  ASSERT_EQ(primitive.vertex_count, 6u);
  const std::array<uint32_t, 6> source{2, 0, 1, 1, 0, 2};
  const std::array<uint16_t, 3> main_joint{0, 0, 1};
  for (uint32_t v = 0; v < 6; ++v) {
    EXPECT_EQ(scene.influences[primitive.first_influence + v].joints[0], main_joint[source[v]]) << v;
    const MorphDelta& delta = scene.morph_deltas[primitive.first_morph_delta + 6 + v];
    EXPECT_EQ(delta.position.x, source[v] == 1 ? 4 : 0) << v;
  }
}

TEST(SceneSkins, GeneratedTangentsKeepInfluences) {
  GltfBuilder builder = test::motion_file();
  const size_t uv = builder.add_data<float>({0, 0, 1, 0, 0, 1}, "VEC2", test::kFloat, 2);
  const size_t material = builder.add_textured_material(test::png(2, 2, 0xffff8080));
  builder.root["materials"][material]["normalTexture"] = {{"index", 0}};
  primitive(builder)["attributes"]["TEXCOORD_0"] = uv;
  primitive(builder)["material"] = material;
  const Scene scene = test::loaded_scene(builder);
  const Primitive& primitive = scene.primitives[0];
  for (uint32_t v = 0; v < primitive.vertex_count; ++v) {
    const bool tip = scene.positions[primitive.first_vertex + v] == glm::vec3(0, 1, 0);
    EXPECT_EQ(scene.influences[primitive.first_influence + v].joints[0], tip ? 1 : 0);
  }
}

TEST(SceneSkins, DifferentInfluencesAreSeparate) {
  GltfBuilder builder = test::motion_file();
  json plain = primitive(builder);
  plain["attributes"].erase("JOINTS_0");
  plain["attributes"].erase("WEIGHTS_0");
  builder.root["meshes"][0]["primitives"].push_back(plain);
  builder.root["meshes"][0]["primitives"].push_back(primitive(builder));
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.primitives.size(), 3u);
  EXPECT_EQ(scene.primitives[1].first_influence, kNone);
  EXPECT_NE(scene.primitives[1].first_vertex, scene.primitives[0].first_vertex);
  EXPECT_EQ(scene.primitives[2].first_influence, scene.primitives[0].first_influence);
  EXPECT_EQ(scene.primitives[2].joint_bounds_count, scene.primitives[0].joint_bounds_count);
  EXPECT_EQ(scene.influences.size(), 3u);
}

TEST(SceneMorphs, DeltasAreTargetMajor) {
  const Scene scene = test::loaded_scene(test::motion_file());
  const Primitive& primitive = scene.primitives[0];
  ASSERT_EQ(primitive.morph_target_count, 2u);
  ASSERT_EQ(scene.morph_deltas.size(), 6u);
  EXPECT_EQ(scene.meshes[0].morph_target_count, 2u);
  const MorphDelta* deltas = &scene.morph_deltas[primitive.first_morph_delta];
  EXPECT_EQ(deltas[2].position, glm::vec3(0, 0, 2));
  EXPECT_EQ(deltas[2].normal, glm::vec3(0));
  EXPECT_EQ(deltas[4].position, glm::vec3(4, 0, 0));
  EXPECT_EQ(deltas[4].normal, glm::vec3(0.5f, 0, 0));
}

TEST(SceneMorphs, NodeWeightsPrecedeMeshes) {
  GltfBuilder builder = test::motion_file();
  builder.add_node("own", {{"mesh", 0}, {"weights", {0.5, 1}}});
  Scene scene = test::loaded_scene(builder);
  const auto weights = [&](const std::string& name) {
    for (const Node& node : scene.nodes) {
      if (node.name == name)
        return std::vector<float>(
            scene.morph_weights.begin() + node.first_morph_weight,
            scene.morph_weights.begin() + node.first_morph_weight + node.morph_weight_count);
    }
    return std::vector<float>();
  };
  EXPECT_EQ(weights("figure"), (std::vector<float>{0.25f, 0}));
  EXPECT_EQ(weights("own"), (std::vector<float>{0.5f, 1}));
  builder.root["meshes"][0].erase("weights");
  scene = test::loaded_scene(builder);
  EXPECT_EQ(weights("figure"), (std::vector<float>{0, 0}));
  EXPECT_TRUE(weights("tip").empty());
}

TEST(SceneMorphs, TargetsHaveFlatNormals) {
  GltfBuilder builder = test::motion_file();
  primitive(builder)["attributes"].erase("NORMAL");
  const size_t lifted = builder.add_data<float>({0, 0, 0, 0, 0, 1, 0, 0, 0}, "VEC3", test::kFloat, 3);
  primitive(builder)["targets"][0]["POSITION"] = lifted;
  const Scene scene = test::loaded_scene(builder);
  const Primitive& primitive = scene.primitives[0];
  // Vertex (1, 0, 0) moves to (1, 0, 1): the triangle's normal tilts by 45 degrees.
  for (uint32_t v = 0; v < 3; ++v) {
    const glm::vec3 normal = normal_of(scene.frames[primitive.first_vertex + v]) +
                             scene.morph_deltas[primitive.first_morph_delta + v].normal;
    EXPECT_NEAR(normal.x, -std::sqrt(0.5f), 1e-6f);
    EXPECT_NEAR(normal.y, 0, 1e-6f);
    EXPECT_NEAR(normal.z, std::sqrt(0.5f), 1e-6f);
  }
}

TEST(SceneMorphs, OtherTargetAttributesAreReported) {
  GltfBuilder builder = test::motion_file();
  primitive(builder)["targets"][0]["COLOR_0"] = test::kTargetA;
  const Scene scene = test::loaded_scene(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("positions, normals and tangents alone"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::scene
