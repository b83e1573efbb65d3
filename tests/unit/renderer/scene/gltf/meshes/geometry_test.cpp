// Test of glTF geometry loading: accessor formats, topologies, and generated attributes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"
#include "tests/unit/renderer/scene/model/vertex_attributes.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

// Vertices of triangle `index` of the first primitive.
std::array<glm::vec3, 3> triangle(const Scene& scene, size_t index) {
  std::array<glm::vec3, 3> corners;
  const Primitive& primitive = scene.primitives[0];
  for (size_t c = 0; c < 3; ++c) {
    corners[c] =
        scene.positions[primitive.first_vertex + scene.indices[primitive.first_index + index * 3 + c]];
  }
  return corners;
}

const std::vector<float> kSquare{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};  // in strip order

TEST(SceneGeometry, StripsAndFansKeepWinding) {
  const std::vector<std::pair<int, std::vector<uint16_t>>> modes{
      {4, {0, 1, 2, 1, 3, 2}}, {5, {0, 1, 2, 3}}, {6, {0, 1, 3, 2}}};
  for (const auto& [mode, indices] : modes) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions(kSquare);
    builder.add_mesh({{"attributes", {{"POSITION", positions}}},
                      {"indices", builder.add_indices(indices)},
                      {"mode", mode}});
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.primitives.size(), 1u);
    ASSERT_EQ(scene.primitives[0].index_count, 6u) << mode;
    for (size_t i = 0; i < 2; ++i) {
      const auto [a, b, c] = triangle(scene, i);
      EXPECT_EQ(glm::cross(b - a, c - a), glm::vec3(0, 0, 1)) << mode << " " << i;
    }
  }
}

TEST(SceneGeometry, RepeatedStripIndicesAreDegenerate) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0});
  const size_t indices = builder.add_indices({0, 1, 2, 2, 3, 3, 4, 5});
  builder.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", 5}});
  EXPECT_EQ(loaded(builder).primitives[0].index_count, 6u);
}

TEST(SceneGeometry, MissingIndicesUseOrder) {
  GltfBuilder builder;
  builder.add_mesh({{"attributes", {{"POSITION", builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}}}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.primitives.at(0).index_count, 3u);
  EXPECT_EQ(triangle(scene, 0)[1], glm::vec3(1, 0, 0));
}

TEST(SceneGeometry, PointsAndLinesBecomeLists) {
  struct Case {
    int mode;
    Topology topology;
    std::vector<uint32_t> list;
  };
  const std::vector<Case> cases{{0, Topology::points, {3, 1, 2, 0}},
                                {1, Topology::lines, {3, 1, 2, 0}},
                                {2, Topology::lines, {3, 1, 1, 2, 2, 0, 0, 3}},
                                {3, Topology::lines, {3, 1, 1, 2, 2, 0}}};
  for (const Case& c : cases) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions(kSquare);
    builder.add_mesh({{"attributes", {{"POSITION", positions}}},
                      {"indices", builder.add_indices({3, 1, 2, 0})},
                      {"mode", c.mode}});
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.primitives.size(), 1u);
    EXPECT_EQ(scene.primitives[0].topology, c.topology);
    EXPECT_FALSE(scene.primitives[0].lit);
    EXPECT_EQ(scene.indices, c.list) << c.mode;
    EXPECT_EQ(scene.positions.size(), 4u);
    EXPECT_TRUE(scene.warnings.empty());
  }
}

TEST(SceneGeometry, LinesWithNormalsAreLit) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions(kSquare);
  const size_t normals = builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  builder.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"mode", 3}});
  EXPECT_TRUE(loaded(builder).primitives[0].lit);
}

TEST(SceneGeometry, TooFewIndicesAreReported) {
  const std::vector<std::pair<int, std::vector<uint16_t>>> modes{{1, {0}},    {2, {0}},    {3, {0}},
                                                                 {4, {0, 1}}, {5, {0, 1}}, {6, {0, 1}}};
  for (const auto& [mode, indices] : modes) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions(kSquare);
    builder.add_mesh({{"attributes", {{"POSITION", positions}}},
                      {"indices", builder.add_indices(indices)},
                      {"mode", mode}});
    const Scene scene = loaded(builder);
    EXPECT_TRUE(scene.primitives.empty()) << mode;
    EXPECT_FALSE(scene.warnings.empty()) << mode;
  }
  GltfBuilder odd;
  const size_t positions = odd.add_positions(kSquare);
  odd.add_mesh(
      {{"attributes", {{"POSITION", positions}}}, {"indices", odd.add_indices({0, 1, 2})}, {"mode", 1}});
  const Scene scene = loaded(odd);
  EXPECT_EQ(scene.indices, (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(SceneGeometry, MissingPositionsAreReported) {
  GltfBuilder builder = test::triangle_file();
  builder.root["meshes"][0]["primitives"][0]["attributes"] = json::object();
  const Scene scene = loaded(builder);
  EXPECT_TRUE(scene.primitives.empty());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "meshes[0].primitives[0] has no POSITION and is not drawn");
}

// A ridge of two triangles; their areas are equal.
TEST(SceneGeometry, NormalsWithoutDirectionAreComputed) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1, 9, 9, 9});
  const size_t normals = builder.add_positions({0, 0, 0, kNan, 0, 1, 0, 2, 0, 0, INFINITY, 0, 0, 0, 0});
  const size_t indices = builder.add_indices({0, 1, 2, 0, 1, 3});
  const json attributes{{"POSITION", positions}, {"NORMAL", normals}};
  builder.add_mesh({{"attributes", attributes}, {"indices", indices}});
  builder.root["meshes"][0]["primitives"].push_back(
      {{"attributes", attributes}, {"indices", builder.add_indices({0, 1, 2})}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "meshes[0] has 5 normals that are zero or not finite; they are computed from its triangles");
  const std::vector<VertexAttributes> attributes_of_vertices = test::attributes_of(scene);
  ASSERT_EQ(attributes_of_vertices.size(), 10u);  // both primitives have normals of their own triangles
  const glm::vec3 ridge = glm::normalize(glm::vec3(0, 1, 1)), z(0, 0, 1), y(0, 1, 0);
  const std::array<glm::vec3, 10> expected{ridge, ridge, y, y, z, z, z, y, z, z};
  for (size_t v = 0; v < 10; ++v)
    EXPECT_NEAR(glm::distance(attributes_of_vertices[v].normal, expected[v]), 0, 1e-4f) << v;
}

TEST(SceneGeometry, TangentsThatAreNotFinite) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const size_t normals = builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
  const size_t tangents =
      builder.add_data<float>({NAN, 0, 0, 1, 0, 1, 0, -1, 0, 1, 0, NAN}, "VEC4", test::kFloat, 4);
  builder.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TANGENT", tangents}}}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(scene.warnings[0].starts_with("meshes[0] has tangents that are not finite"));
  EXPECT_EQ(tangent_of(scene, 0), glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(tangent_of(scene, 1), glm::vec4(0, 1, 0, -1));
  EXPECT_EQ(tangent_of(scene, 2), glm::vec4(0, 1, 0, 1));
}

TEST(SceneGeometry, ViewlessAccessorsAreZero) {
  GltfBuilder builder;
  json& accessors = builder.root["accessors"];
  // Positions: zeros but for two; normals: zeros; indices: zeros but for two of each triangle.
  const auto sparse = [&](size_t count, const char* type, test::ComponentType component, size_t of_indices,
                          size_t of_values, size_t replaced) {
    accessors.push_back({{"componentType", component},
                         {"type", type},
                         {"count", count},
                         {"sparse",
                          {{"count", replaced},
                           {"indices", {{"bufferView", of_indices}, {"componentType", 5121}}},
                           {"values", {{"bufferView", of_values}}}}}});
    return accessors.size() - 1;
  };
  const auto view = [&](const auto& values) { return builder.add_view(std::as_bytes(std::span(values))); };
  const std::vector<uint8_t> at{1, 2};
  const std::vector<float> values{1, 0, 0, 0, 1, 0};
  const std::vector<uint16_t> corners{1, 2};
  const size_t at_view = view(at);
  const size_t positions = sparse(3, "VEC3", test::kFloat, at_view, view(values), 2);
  const size_t indices = sparse(6, "SCALAR", test::kUnsignedShort, at_view, view(corners), 2);
  accessors.push_back({{"componentType", test::kFloat}, {"type", "VEC3"}, {"count", 3}});
  builder.add_mesh(
      {{"attributes", {{"POSITION", positions}, {"NORMAL", accessors.size() - 1}}}, {"indices", indices}});
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.indices, (std::vector<uint32_t>{0, 1, 2, 0, 0, 0}));
  ASSERT_EQ(scene.positions.size(), 3u);
  EXPECT_EQ(scene.positions[1], glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.positions[2], glm::vec3(0, 1, 0));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(scene.warnings[0].starts_with("meshes[0] has 3 normals that are zero"));
  EXPECT_EQ(normal_of(scene.frames[2]), glm::vec3(0, 0, 1));
}

TEST(SceneGeometry, UnusableValuesAreReplaced) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  const size_t normals = builder.add_positions({0, 0, 0, 0, 0, 1, 0, 2, 0});
  const size_t tangents =
      builder.add_data<float>({0, 0, 0, 1, 1, 0, 0, 0, 0, 2, 3, -0.5f}, "VEC4", test::kFloat, 4);
  const size_t colors =
      builder.add_data<float>({2, -1, 0.5f, 1, 0, 0, 0, -3, 1, 1, 1, 7}, "VEC4", test::kFloat, 4);
  builder.add_mesh(
      {{"attributes",
        {{"POSITION", positions}, {"NORMAL", normals}, {"TANGENT", tangents}, {"COLOR_0", colors}}}});
  const Scene scene = loaded(builder);
  const std::vector<VertexAttributes> attributes = test::attributes_of(scene);
  ASSERT_EQ(attributes.size(), 3u);
  EXPECT_EQ(attributes[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(attributes[2].normal, glm::vec3(0, 1, 0));
  EXPECT_EQ(attributes[0].tangent, glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(attributes[1].tangent, glm::vec4(1, 0, 0, 1));
  EXPECT_NEAR(
      glm::distance(attributes[2].tangent, glm::vec4(0, 2 / std::sqrt(13.0f), 3 / std::sqrt(13.0f), -1)), 0,
      1e-4f);
  EXPECT_EQ(attributes[0].color, glm::vec4(1, 0, 32768 / 65535.0f, 1));
  EXPECT_EQ(attributes[1].color, glm::vec4(0));
  EXPECT_EQ(attributes[2].color, glm::vec4(1));
}

TEST(SceneGeometry, DegenerateTrianglesHaveFiniteNumbers) {
  GltfBuilder builder;
  builder.add_textured_material(test::png(1, 1, 0xffff8080));
  builder.root["materials"][0]["normalTexture"] = {{"index", 0}};
  const size_t positions = builder.add_positions(kSquare);
  const size_t uv = builder.add_data<float>({0, 0, 0, 0, 0, 0, 0, 0}, "VEC2", test::kFloat, 2);
  builder.add_mesh({{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}},
                    {"indices", builder.add_indices({0, 0, 0, 0, 1, 1, 0, 1, 2})},
                    {"material", 0}});
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.primitives[0].index_count, 9u);
  for (const VertexAttributes& vertex : test::attributes_of(scene)) {
    EXPECT_NEAR(glm::length(vertex.normal), 1, 1e-4);
    EXPECT_NEAR(glm::length(glm::vec3(vertex.tangent)), 1, 1e-6);
  }
}

TEST(SceneGeometry, MissingNormalsAreFlat) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  builder.add_mesh(
      {{"attributes", {{"POSITION", positions}}}, {"indices", builder.add_indices({0, 1, 2, 0, 2, 3})}});
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.positions.size(), 6u);
  EXPECT_EQ(normal_of(scene.frames[scene.indices[0]]), glm::vec3(0, 0, 1));
  EXPECT_EQ(normal_of(scene.frames[scene.indices[3]]), glm::vec3(1, 0, 0));
}

TEST(SceneGeometry, AttributesOfEveryComponentType) {
  GltfBuilder builder;
  json attributes;
  attributes["POSITION"] =
      builder.add_data<int16_t>({0, 0, 0, 0, 100, 0, 0, 0, 0, 50, 0, 0}, "VEC3", test::kShort, 4);
  // Elements of 6 bytes in a stride of 8, as KHR_mesh_quantization requires.
  builder.root["bufferViews"].back()["byteStride"] = 8;
  attributes["NORMAL"] =
      builder.add_data<int8_t>({0, 0, 127, 0, 0, -128, 127, 0, 0, 0, 0, 0}, "VEC3", test::kByte, 4, true);
  builder.root["bufferViews"].back()["byteStride"] = 4;
  attributes["TANGENT"] =
      builder.add_data<float>({1, 0, 0, 1, 1, 0, 0, -1, 0, 0, 1, 1}, "VEC4", test::kFloat, 4);
  attributes["TEXCOORD_0"] =
      builder.add_data<uint16_t>({0, 65535, 65535, 0, 0, 0}, "VEC2", test::kUnsignedShort, 2, true);
  attributes["TEXCOORD_1"] = builder.add_data<uint8_t>({0, 255, 0, 0, 51, 0, 0, 0, 0, 0, 0, 0}, "VEC2",
                                                       test::kUnsignedByte, 4, true);
  builder.root["bufferViews"].back()["byteStride"] = 4;
  attributes["COLOR_0"] = builder.add_data<float>({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", test::kFloat, 3);
  builder.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  builder.add_mesh({{"attributes", attributes}});
  const Scene scene = loaded(builder);
  const std::vector<VertexAttributes> read = test::attributes_of(scene);
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(scene.positions[1], glm::vec3(100, 0, 0));
  EXPECT_EQ(read[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(read[1].normal.y, -read[1].normal.z) << "-128 and -127 both stand for -1";
  EXPECT_NEAR(glm::distance(glm::vec3(read[1].tangent), glm::vec3(1, 0, 0)), 0, 1e-4);
  EXPECT_EQ(read[1].tangent.w, -1);
  EXPECT_EQ(read[0].uv0, glm::vec2(0, 1));
  EXPECT_EQ(read[1].uv1, glm::vec2(0.2f, 0));
  EXPECT_EQ(read[1].color, glm::vec4(0, 1, 0, 1)) << "alpha is 1 where the file has three components";
}

TEST(SceneGeometry, InterleavedVertices) {
  GltfBuilder builder;
  const std::vector<float> vertices{0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0};
  const size_t view = builder.add_view(std::as_bytes(std::span(vertices)), 24);
  const size_t positions = builder.add_accessor(view, 3, "VEC3", test::kFloat);
  const size_t normals = builder.add_accessor(view, 3, "VEC3", test::kFloat);
  builder.root["accessors"][normals]["byteOffset"] = 12;
  builder.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}});
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.positions.at(2), glm::vec3(0, 1, 0));
  EXPECT_EQ(normal_of(scene.frames.at(2)), glm::vec3(1, 0, 0));
}

TEST(SceneGeometry, SparseOverridesBase) {
  for (const bool over_zeros : {false, true}) {
    GltfBuilder builder = test::triangle_file();
    const std::vector<uint8_t> sparse_indices{1, 2};
    const std::vector<float> sparse_values{4, 0, 0, 0, 5, 0};
    const size_t indices = builder.add_view(std::as_bytes(std::span(sparse_indices)));
    const size_t values = builder.add_view(std::as_bytes(std::span(sparse_values)));
    json& accessor = builder.root["accessors"][0];
    if (over_zeros) accessor.erase("bufferView");
    accessor["sparse"] = {{"count", 2},
                          {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                          {"values", {{"bufferView", values}}}};
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.positions.size(), 3u);
    EXPECT_EQ(triangle(scene, 0),
              (std::array<glm::vec3, 3>{glm::vec3(0), glm::vec3(4, 0, 0), glm::vec3(0, 5, 0)}));
  }
}

TEST(SceneGeometry, IndicesOfEveryWidth) {
  const auto check = [](GltfBuilder& builder, size_t indices) {
    builder.root["meshes"][0]["primitives"][0]["indices"] = indices;
    EXPECT_EQ(triangle(loaded(builder), 0)[0], glm::vec3(0, 1, 0));
  };
  GltfBuilder builder = test::triangle_file();
  check(builder, builder.add_data<uint8_t>({2, 0, 1}, "SCALAR", test::kUnsignedByte, 1));
  check(builder, builder.add_data<uint16_t>({2, 0, 1}, "SCALAR", test::kUnsignedShort, 1));
  check(builder, builder.add_data<uint32_t>({2, 0, 1}, "SCALAR", test::kUnsignedInt, 1));
}

TEST(SceneGeometry, PrimitivesShareVertices) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions(kSquare);
  const size_t normals =
      builder.add_data<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", test::kFloat, 3);
  const json attributes{{"POSITION", positions}, {"NORMAL", normals}};
  builder.add_mesh({{"attributes", attributes}, {"indices", builder.add_indices({0, 1, 2})}});
  builder.add_mesh({{"attributes", attributes}, {"indices", builder.add_indices({1, 3, 2})}});
  builder.root["meshes"].push_back(builder.root["meshes"][0]);
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.positions.size(), 4u);
  EXPECT_EQ(scene.indices.size(), 6u);
  ASSERT_EQ(scene.primitives.size(), 3u);
  EXPECT_EQ(scene.primitives[1].first_vertex, 0u);
  EXPECT_EQ(scene.primitives[2].first_index, scene.primitives[0].first_index);
}

}  // namespace
}  // namespace fire3dv::scene
