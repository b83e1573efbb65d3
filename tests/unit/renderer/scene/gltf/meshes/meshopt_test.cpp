// Test of EXT_meshopt_compression: valid files as compressors write them, and damaged ones.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/vertices.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

using Encoded = std::vector<unsigned char>;

template <typename T>
Encoded encode_vertices(const std::vector<T>& vertices, size_t stride) {
  const size_t count = vertices.size() * sizeof(T) / stride;
  Encoded bytes(meshopt_encodeVertexBufferBound(count, stride));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), vertices.data(), count, stride));
  return bytes;
}

Encoded encode_triangles(const std::vector<unsigned>& indices, size_t vertices) {
  Encoded bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices));
  bytes.resize(meshopt_encodeIndexBuffer(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

Encoded encode_sequence(const std::vector<unsigned>& indices, size_t vertices) {
  Encoded bytes(meshopt_encodeIndexSequenceBound(indices.size(), vertices));
  bytes.resize(meshopt_encodeIndexSequence(bytes.data(), bytes.size(), indices.data(), indices.size()));
  return bytes;
}

// Adds a compressed buffer view of the fallback buffer, as compressors do; returns its index.
size_t add_compressed(GltfBuilder& builder, const Encoded& bytes, size_t count, size_t stride,
                      const char* mode, const char* filter = nullptr) {
  const size_t view = builder.add_view(std::as_bytes(std::span(bytes)));
  json& parent = builder.root["bufferViews"][view];
  json extension{{"buffer", 0},
                 {"byteOffset", parent["byteOffset"]},
                 {"byteLength", bytes.size()},
                 {"count", count},
                 {"byteStride", stride},
                 {"mode", mode}};
  if (filter != nullptr) extension["filter"] = filter;
  parent = {{"buffer", 1},
            {"byteLength", count * stride},
            {"extensions", {{"EXT_meshopt_compression", extension}}}};
  if (mode == std::string("ATTRIBUTES")) parent["byteStride"] = stride;
  return view;
}

// The builder adds the length of its own buffer only without an existing list of buffers.
GltfBuilder with_fallback(GltfBuilder builder) {
  builder.root["buffers"] = {
      {{"byteLength", builder.bin.size()}},
      {{"byteLength", 1 << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  builder.root["extensionsRequired"] = {"EXT_meshopt_compression"};
  return builder;
}

const std::vector<float> kSquare{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
const std::vector<unsigned> kTwoTriangles{0, 1, 2, 2, 1, 3};

// A square with compressed positions and indices: accessors 0 and 1.
GltfBuilder compressed_square() {
  GltfBuilder builder;
  const size_t positions = add_compressed(builder, encode_vertices(kSquare, 12), 4, 12, "ATTRIBUTES");
  const size_t indices = add_compressed(builder, encode_triangles(kTwoTriangles, 4), 6, 2, "TRIANGLES");
  builder.add_accessor(positions, 4, "VEC3", test::kFloat);
  builder.add_accessor(indices, 6, "SCALAR", test::kUnsignedShort);
  builder.add_node(
      "square",
      {{"mesh", builder.add_mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 4}})}});
  return with_fallback(builder);
}

TEST(SceneMeshopt, VerticesAndTriangles) {
  const auto scene = load(compressed_square());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE(scene->warnings.empty());
  ASSERT_EQ(scene->indices.size(), 6u);
  ASSERT_EQ(scene->positions.size(), 6u);  // flat normals split the vertices
  // The codec may rotate a triangle's vertices; its area stays.
  float area = 0;
  for (size_t i = 0; i < 6; i += 3) {
    const glm::vec3 a = scene->positions[i], b = scene->positions[i + 1], c = scene->positions[i + 2];
    area += glm::cross(b - a, c - a).z / 2;
  }
  EXPECT_EQ(area, 1);
}

TEST(SceneMeshopt, IndexSequencesOfBothWidths) {
  for (const size_t stride : {size_t{2}, size_t{4}}) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions(kSquare);
    const std::vector<unsigned> sequence{0, 1, 3, 2, 0, 3};
    const size_t view = add_compressed(builder, encode_sequence(sequence, 4), 6, stride, "INDICES");
    const size_t indices =
        builder.add_accessor(view, 6, "SCALAR", stride == 2 ? test::kUnsignedShort : test::kUnsignedInt);
    builder.add_mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"mode", 1}});
    const auto scene = load(with_fallback(builder));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene->indices, (std::vector<uint32_t>(sequence.begin(), sequence.end())));
  }
}

TEST(SceneMeshopt, OctahedralNormalsOfBothWidths) {
  const std::vector<float> normals{0, 0, 1, 0, 0.6f, 0, 0.8f, 0, -1, 0, 0, 0, 0.36f, 0.48f, -0.8f, 0};
  for (const size_t stride : {size_t{4}, size_t{8}}) {
    GltfBuilder builder;
    const size_t positions = builder.add_positions(kSquare);
    std::vector<unsigned char> filtered(4 * stride);
    meshopt_encodeFilterOct(filtered.data(), 4, stride, stride == 4 ? 8 : 16, normals.data());
    const size_t view =
        add_compressed(builder, encode_vertices(filtered, stride), 4, stride, "ATTRIBUTES", "OCTAHEDRAL");
    const size_t accessor =
        builder.add_accessor(view, 4, "VEC3", stride == 4 ? test::kByte : test::kShort, true);
    builder.add_mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", accessor}}}, {"mode", 5}});
    const auto scene = load(with_fallback(builder));
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    for (size_t i = 0; i < 4; ++i) {
      const glm::vec3 expected(normals[i * 4], normals[i * 4 + 1], normals[i * 4 + 2]);
      EXPECT_NEAR(glm::distance(normal_of(scene->frames[i]), expected), 0, stride == 4 ? 2e-2 : 1e-4) << i;
    }
  }
}

TEST(SceneMeshopt, QuaternionsAndExponentials) {
  GltfBuilder builder;
  const std::vector<float> rotations{0, 0, 0.70710678f, 0.70710678f, 0, 0, 0, 1};
  std::vector<unsigned char> filtered(16);
  meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, rotations.data());
  const size_t turns =
      add_compressed(builder, encode_vertices(filtered, 8), 2, 8, "ATTRIBUTES", "QUATERNION");
  const std::vector<float> translations{1, 2.5f, -1000, 0.001f, 0, 7};
  std::vector<unsigned char> packed(24);
#if MESHOPTIMIZER_VERSION >= 190
  meshopt_encodeFilterExp(packed.data(), 2, 12, 20, translations.data(), meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(packed.data(), 2, 12, 20, translations.data());
#endif
  const size_t moves =
      add_compressed(builder, encode_vertices(packed, 12), 2, 12, "ATTRIBUTES", "EXPONENTIAL");
  const size_t rotation = builder.add_accessor(turns, 2, "VEC4", test::kShort, true);
  const size_t translation = builder.add_accessor(moves, 2, "VEC3", test::kFloat);
  builder.add_node("field", {{"mesh", builder.add_triangle_mesh()},
                             {"extensions",
                              {{"EXT_mesh_gpu_instancing",
                                {{"attributes", {{"ROTATION", rotation}, {"TRANSLATION", translation}}}}}}}});
  const auto scene = load(with_fallback(builder));
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->nodes.size(), 3u);
  const glm::mat4& first = scene->nodes[1].parent_from_node;
  EXPECT_NEAR(glm::distance(glm::vec3(first[0]), glm::vec3(0, 1, 0)), 0, 1e-4);
  EXPECT_NEAR(first[3].y, 2.5f, 1e-2);
  EXPECT_NEAR(first[3].z, -1000, 1e-2);
  EXPECT_NEAR(scene->nodes[2].parent_from_node[3].z, 7, 1e-4);
}

TEST(SceneMeshopt, AFallbackIsNeverRead) {
  GltfBuilder builder = compressed_square();
  builder.root["buffers"][1]["uri"] = "not-there.bin";
  EXPECT_TRUE(load(builder).ok());
  builder.root["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 48}});
  builder.root["accessors"][0]["bufferView"] = 2;
  const auto scene = load(builder);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("buffers[1] holds no bytes"), std::string::npos)
      << scene.error().message;
}

TEST(SceneMeshopt, FaultsByName) {
  struct Fault {
    size_t view;
    json members;
    std::string text;
  };
  const std::vector<Fault> faults{
      {0, {{"buffer", 7}}, "buffers[7], but there are 2"},
      {0, {{"buffer", 1}}, "buffers[1] holds 0"},
      {0, {{"byteOffset", 1 << 20}}, "reaches from byte 1048576"},
      {0, {{"byteLength", 9007199254740992}}, "over 9007199254740992 bytes"},
      {0, {{"byteLength", 3}}, "the compressed bytes are damaged"},
      {0, {{"count", 0}}, "has a count of 0"},
      {0, {{"count", 5}}, "holds 5 elements of 12 bytes, but the buffer view's byteLength is 48"},
      {0, {{"count", 9007199254740992}}, "holds 9007199254740992 elements"},
      {0, {{"byteStride", 0}}, "byteStride of 0"},
      {0, {{"byteStride", 6}}, "byteStride of 6, not a multiple of 4"},
      {0, {{"byteStride", 260}}, "byteStride of 260, not a multiple of 4 up to 256"},
      {0, {{"byteStride", 16}, {"count", 3}}, "byteStride of 16, but the buffer view's is 12"},
      {0, {{"mode", "ATOMS"}}, "the unknown mode"},
      {0, {{"mode", 0}}, "mode is not of the type"},
      {0, {{"mode", nullptr}}, "mode is missing"},
      {0, {{"filter", "SEPIA"}}, "the unknown filter"},
      {0, {{"filter", "QUATERNION"}}, "QUATERNION does not go with a byteStride of 12"},
      {0, {{"filter", "OCTAHEDRAL"}}, "OCTAHEDRAL does not go with a byteStride of 12"},
      {1, {{"filter", "EXPONENTIAL"}}, "a filter, which only attributes may have"},
      {1, {{"byteStride", 1}, {"count", 12}}, "but indices have 2 or 4"},
      {1, {{"mode", "INDICES"}}, "the compressed bytes are damaged"},
      {1, {{"count", 5}}, "a count of 5, not a multiple of 3"}};
  for (const Fault& fault : faults) {
    GltfBuilder builder = compressed_square();
    json& extension = builder.root["bufferViews"][fault.view]["extensions"]["EXT_meshopt_compression"];
    for (const auto& [member, value] : fault.members.items()) {
      if (value.is_null()) {
        extension.erase(member);
      } else {
        extension[member] = value;
      }
    }
    const auto scene = load(builder);
    ASSERT_FALSE(scene.ok()) << fault.text;
    EXPECT_NE(scene.error().message.find(fault.text), std::string::npos) << scene.error().message;
    EXPECT_NE(scene.error().message.find("bufferViews[" + std::to_string(fault.view) + "]"),
              std::string::npos);
  }
}

TEST(SceneMeshopt, RepeatedViewsAreBounded) {
  GltfBuilder builder;
  const std::vector<float> zeros(size_t{63} * 20000, 0.0f);
  const Encoded bytes = encode_vertices(zeros, 252);
  const size_t view = add_compressed(builder, bytes, 20000, 252, "ATTRIBUTES");
  const json parent = builder.root["bufferViews"][view];
  for (int i = 0; i < 60; ++i) builder.root["bufferViews"].push_back(parent);
  builder = with_fallback(builder);
  builder.root["buffers"][1]["byteLength"] = 20000 * 252;
  const auto scene = load(builder);
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("cannot hold so much"), std::string::npos) << scene.error().message;
  builder.root["bufferViews"] = json::array({parent});
  const auto single = load(builder);
  EXPECT_TRUE(single.ok()) << single.error().message;
}

TEST(SceneMeshopt, EveryByteDamaged) {
  const GltfBuilder good = compressed_square();
  size_t loaded = 0, refused = 0;
  for (size_t i = 0; i < good.bin.size(); ++i) {
    for (const int flip : {0x01, 0x10, 0x80, 0xff}) {
      GltfBuilder builder = good;
      builder.bin[i] ^= static_cast<std::byte>(flip);
      const auto scene = load(builder);
      ++(scene ? loaded : refused);
      if (!scene) continue;
      for (const uint32_t index : scene->indices) ASSERT_LT(index, scene->positions.size());
      for (const glm::vec3& position : scene->positions)
        ASSERT_TRUE(std::isfinite(position.x + position.y + position.z));
    }
  }
  EXPECT_GT(loaded, 0u);
  EXPECT_GT(refused, 0u);
}

}  // namespace
}  // namespace fire3dv::scene
