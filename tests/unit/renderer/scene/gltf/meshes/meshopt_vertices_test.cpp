// Test of the parts of KHR_meshopt_compression that this project decodes itself: version 1 of the vertex
// codec and the filter COLOR. Streams and filtered colours were made once by the encoder of
// meshoptimizer 1.0.
#include "renderer/scene/gltf/meshes/meshopt_vertices.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/model/vertices.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

std::vector<std::byte> from_hex(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoul(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

constexpr size_t kCount = 24, kStride = 16;

// Elements of which each channel compresses best in another way.
std::vector<std::byte> elements() {
  std::vector<std::byte> bytes;
  for (uint32_t i = 0; i < kCount; ++i) {
    const std::array<uint32_t, 4> words{(300 * i & 0xffff) | (1000 - i) << 16, (i * i) << 20 | (i & 1) << 31,
                                        0x05050505 + (i == 20 ? 200u : 0u), i % 3};
    const auto element = std::as_bytes(std::span(words));
    bytes.insert(bytes.end(), element.begin(), element.end());
  }
  return bytes;
}

// Channel modes: 2-byte deltas, XOR rotated by 4 bits, bytes, bytes. All four control modes occur.
const std::vector<std::byte>& stream() {
  static const std::vector<std::byte> bytes = from_hex(
      "a197e9a8a9005858585858585858585858585858585858585858585858052aaaaaaaaaaa00000515555555555500000a"
      "08888888888888889888888b000000000001050d19093d157111351de9396d25e121652df9295df50430006f70060223"
      "223223223223aeba00000303000000000000e80300000000050505050000000001420000");
  return bytes;
}

bool decodes(const std::vector<std::byte>& bytes, std::vector<std::byte>& to) {
  to.assign(kCount * kStride, std::byte{0xcd});
  return decode_vertices_v1(to.data(), kCount, kStride, bytes);
}

TEST(MeshoptVertices, StreamOfTheReferenceEncoder) {
  std::vector<std::byte> decoded;
  ASSERT_TRUE(is_vertex_stream_v1(stream()));
  ASSERT_TRUE(decodes(stream(), decoded));
  EXPECT_EQ(decoded, elements());
}

// The example of the extension's text, as byte 0 of sixteen elements of four bytes.
TEST(MeshoptVertices, ExampleOfTheSpecification) {
  // Header; controls: bit lengths {0, 1, 2, 4}, then zeros; delta mode 3: four bits; tail of 24 bytes.
  const auto bytes = from_hex(
      "a1"
      "a8"
      "03"
      "175ff0bc77a9210034b5" +
      std::string(38, '0') +
      "00000000"
      "00");
  std::vector<std::byte> decoded(16 * 4);
  ASSERT_TRUE(decode_vertices_v1(decoded.data(), 16, 4, bytes));
  const std::array<int, 16> deltas{-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0};
  int value = 0;
  for (size_t i = 0; i < 16; ++i) {
    value = (value + deltas[i]) & 0xff;
    EXPECT_EQ(std::to_integer<int>(decoded[i * 4]), value) << i;
    EXPECT_EQ(std::to_integer<int>(decoded[i * 4 + 1]), 0) << i;
  }
}

TEST(MeshoptVertices, InvalidChannelModesAreRefused) {
  for (const unsigned mode : {0x03u, 0x0fu, 0x10u, 0x11u, 0xf3u}) {
    auto bytes = stream();
    bytes.back() = static_cast<std::byte>(mode);
    std::vector<std::byte> decoded;
    EXPECT_FALSE(decodes(bytes, decoded)) << mode;
  }
}

TEST(MeshoptVertices, DamagedStreamsAreSafe) {
  std::vector<std::byte> decoded;
  for (size_t length = 0; length < stream().size(); ++length) {
    const std::vector<std::byte> cut(stream().begin(), stream().begin() + static_cast<ptrdiff_t>(length));
    EXPECT_FALSE(decodes(cut, decoded)) << length;
  }
  auto longer = stream();
  longer.push_back({});
  EXPECT_FALSE(decodes(longer, decoded));
  size_t refused = 0;
  for (size_t bit = 0; bit < stream().size() * 8; ++bit) {
    auto bytes = stream();
    bytes[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    refused += !decodes(bytes, decoded);
  }
  EXPECT_GT(refused, 0u);
}

TEST(MeshoptVertices, ColorsWithoutScaleAreBlack) {
  std::array<std::byte, 4> color{std::byte{7}, std::byte{0x81}, std::byte{5}, std::byte{0}};
  decode_color_filter(color.data(), 1, 1);
  EXPECT_EQ(color, (std::array<std::byte, 4>{}));
}

// A file with one view compressed by the extension.
struct Compressed {
  GltfBuilder builder;
  size_t view = 0;
};
Compressed compressed(const std::vector<std::byte>& bytes, size_t count, size_t stride,
                      const char* filter = nullptr) {
  Compressed file;
  file.view = file.builder.add_view(bytes);
  json& parent = file.builder.root["bufferViews"][file.view];
  json extension{{"buffer", 0},
                 {"byteOffset", parent["byteOffset"]},
                 {"byteLength", bytes.size()},
                 {"count", count},
                 {"byteStride", stride},
                 {"mode", "ATTRIBUTES"}};
  if (filter != nullptr) extension["filter"] = filter;
  parent = {{"buffer", 1},
            {"byteLength", count * stride},
            {"byteStride", stride},
            {"extensions", {{"KHR_meshopt_compression", extension}}}};
  return file;
}

GltfBuilder with_placeholder(GltfBuilder builder) {
  builder.root["buffers"] = {
      {{"byteLength", builder.bin.size()}},
      {{"byteLength", 4096}, {"extensions", {{"KHR_meshopt_compression", {{"fallback", true}}}}}}};
  builder.root["extensionsUsed"] = {"KHR_meshopt_compression"};
  builder.root["extensionsRequired"] = {"KHR_meshopt_compression"};
  return builder;
}

TEST(MeshoptVertices, FileWithVersionOne) {
  // The two unsigned shorts of the first channel are x and y of points.
  Compressed file = compressed(stream(), kCount, kStride);
  json accessor{{"bufferView", file.view},
                {"componentType", test::kUnsignedShort},
                {"type", "VEC3"},
                {"count", kCount}};
  file.builder.root["accessors"].push_back(accessor);
  file.builder.add_node("points",
                        {{"mesh", file.builder.add_mesh({{"attributes", {{"POSITION", 0}}}, {"mode", 0}})}});
  const Scene scene = loaded(with_placeholder(file.builder));
  ASSERT_EQ(scene.positions.size(), kCount);
  for (uint32_t i = 0; i < kCount; ++i) {
    EXPECT_EQ(scene.positions[i].x, static_cast<float>(300 * i));
    EXPECT_EQ(scene.positions[i].y, static_cast<float>(1000 - i));
  }
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(MeshoptVertices, ColorFilterOfBothWidths) {
  // (1, 0, 0, 1), (0, 1, 0, 0.5), (0, 0, 1, 0), (0.25, 0.5, 0.75, 1), filtered with 8 and 12 bits, then in
  // version 1: controls of literals, byte deltas, a baseline of zeros.
  const auto encoded = [](size_t stride, std::string_view filtered) {
    const auto colors = from_hex(filtered);
    std::vector<std::byte> bytes{std::byte{0xa1}};
    bytes.insert(bytes.end(), stride / 4, std::byte{0xff});
    for (size_t b = 0; b < stride; ++b) {
      int previous = 0;
      for (size_t i = 0; i < 4; ++i) {
        const int value = std::to_integer<int>(colors[i * stride + b]);
        const auto delta = static_cast<int8_t>(value - previous);
        bytes.push_back(static_cast<std::byte>(delta < 0 ? ~(delta << 1) : delta << 1));
        previous = value;
      }
    }
    bytes.resize(bytes.size() + 24);
    return bytes;
  };
  for (const bool wide : {false, true}) {
    const size_t stride = wide ? 8 : 4;
    Compressed file =
        compressed(wide ? encoded(8, "0004ff0701fcff0fff070000ff07000c000401f800fc0008000801fc0000ff0f")
                        : encoded(4, "407fc1ff7f007fc04081c08080c100ff"),
                   4, stride, "COLOR");
    const size_t colors = file.builder.add_accessor(file.view, 4, "VEC4",
                                                    wide ? test::kUnsignedShort : test::kUnsignedByte, true);
    const size_t positions = file.builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    file.builder.add_mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", colors}}}, {"mode", 0}});
    const Scene scene = loaded(with_placeholder(file.builder));
    ASSERT_EQ(scene.positions.size(), 4u);
    const std::array<glm::vec4, 4> expected{
        {{1, 0, 0, 1}, {0, 1, 0, 0.5f}, {0, 0, 1, 0}, {0.25f, 0.5f, 0.75f, 1}}};
    for (uint32_t v = 0; v < 4; ++v) {
      const glm::vec4 color = attributes_of(scene, v).color;
      // Alpha has one bit less.
      for (int c = 0; c < 4; ++c) EXPECT_NEAR(color[c], expected[v][c], wide ? 1e-3f : 1e-2f) << v << c;
    }
  }
}

TEST(MeshoptVertices, ContradictionsAreErrors) {
  const auto error_after = [](const auto& edit) {
    Compressed file = compressed(stream(), kCount, kStride);
    edit(file.builder.root["bufferViews"][file.view]["extensions"]);
    const auto scene = load(with_placeholder(file.builder));
    return scene ? std::string("no error") : scene.error().message;
  };
  EXPECT_NE(error_after([](json& e) {
              e["EXT_meshopt_compression"] = e["KHR_meshopt_compression"];
            }).find("bufferViews[0] has both KHR_meshopt_compression and EXT_meshopt_compression"),
            std::string::npos);
  EXPECT_NE(error_after([](json& e) {
              e["KHR_meshopt_compression"]["filter"] = "COLOR";
            }).find("COLOR does not go with a byteStride of 16"),
            std::string::npos);
  EXPECT_NE(error_after([](json& e) {
              e["KHR_meshopt_compression"]["byteLength"] = 90;
            }).find("bufferViews[0].extensions.KHR_meshopt_compression: the compressed bytes are damaged"),
            std::string::npos);
  // COLOR is no filter of the older extension.
  EXPECT_NE(error_after([](json& e) {
              e = {{"EXT_meshopt_compression", e["KHR_meshopt_compression"]}};
              e["EXT_meshopt_compression"]["filter"] = "COLOR";
            }).find("unknown filter"),
            std::string::npos);
}

}  // namespace
}  // namespace fire3dv::scene
