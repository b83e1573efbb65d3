// Test of KTX 2.0 textures: the container, uncompressed texels, Zstandard, orientation, swizzle, transfer
// function, and KHR_texture_basisu in glTF.
#include <gtest/gtest.h>
#include <zstd.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"
#include "tests/unit/renderer/scene/textures/ktx2/ktx2_builder.h"

namespace fire3dv::scene {
namespace {

using ktx2_test::decoded;
using ktx2_test::Ktx2Builder;
using ktx2_test::texels_of;
using test::GltfBuilder;

std::vector<std::byte> bytes_of(const std::vector<uint8_t>& values) {
  std::vector<std::byte> bytes;
  for (const uint8_t value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

std::vector<std::byte> compressed(const std::vector<std::byte>& bytes) {
  std::vector<std::byte> packed(ZSTD_compressBound(bytes.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 3));
  return packed;
}

// 3 x 2 texels of R8G8B8A8.
const std::vector<uint8_t> kTexels{1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                                   13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24};

Ktx2Builder rgba_file() {
  Ktx2Builder builder;
  builder.format = 37;
  builder.width = 3;
  builder.height = 2;
  builder.channels = {0, 1, 2, 15};
  builder.level = bytes_of(kTexels);
  return builder;
}

// UASTC block of one colour.
std::vector<std::byte> one_color_block(uint32_t red, uint32_t green, uint32_t blue, uint32_t alpha) {
  ktx2_test::BitWriter writer;
  writer.bits(0x17, 5);
  for (const uint32_t channel : {red, green, blue, alpha}) writer.bits(channel, 8);
  std::vector<std::byte> block = writer.bytes();
  block.resize(16);
  return block;
}

Ktx2Builder uastc_file() {
  Ktx2Builder builder;
  builder.width = 6;
  builder.height = 3;
  builder.model = 166;
  builder.channels = {3};
  for (const std::vector<std::byte>& block :
       {one_color_block(10, 20, 30, 40), one_color_block(50, 60, 70, 80)})
    builder.level.insert(builder.level.end(), block.begin(), block.end());
  return builder;
}

std::vector<uint8_t> texels(const Ktx2Builder& builder) {
  const Result<Image> image = decoded(builder.file());
  EXPECT_TRUE(image.ok()) << image.error().message;
  return image ? texels_of(*image) : std::vector<uint8_t>();
}

std::vector<uint8_t> texel(const Ktx2Builder& builder, size_t index) {
  const std::vector<uint8_t> all = texels(builder);
  return all.size() < 4 * index + 4
             ? all
             : std::vector<uint8_t>(all.begin() + static_cast<ptrdiff_t>(4 * index),
                                    all.begin() + static_cast<ptrdiff_t>(4 * index + 4));
}

TEST(Ktx2, UncompressedTexels) {
  EXPECT_EQ(texels(rgba_file()), kTexels);
  for (const uint32_t format : {23u, 29u}) {
    Ktx2Builder rgb = rgba_file();
    rgb.format = format;
    rgb.height = 1;
    rgb.level = bytes_of({1, 2, 3, 4, 5, 6, 7, 8, 9});
    EXPECT_EQ(texels(rgb), (std::vector<uint8_t>{1, 2, 3, 255, 4, 5, 6, 255, 7, 8, 9, 255}));
  }
}

TEST(Ktx2, Zstandard) {
  Ktx2Builder builder = rgba_file();
  builder.scheme = 2;
  builder.level = compressed(builder.level);
  EXPECT_EQ(texels(builder), kTexels);
  Ktx2Builder uastc = uastc_file();
  const std::vector<uint8_t> plain = texels(uastc);
  uastc.scheme = 2;
  uastc.level = compressed(uastc.level);
  EXPECT_EQ(texels(uastc), plain);
}

TEST(Ktx2, BlocksOfUastcOverhangTheImage) {
  const std::vector<uint8_t> all = texels(uastc_file());
  ASSERT_EQ(all.size(), size_t{4} * 6 * 3);
  EXPECT_EQ(texel(uastc_file(), 3), (std::vector<uint8_t>{10, 20, 30, 40}));
  EXPECT_EQ(texel(uastc_file(), 4), (std::vector<uint8_t>{50, 60, 70, 80}));
  EXPECT_EQ(texel(uastc_file(), 17), (std::vector<uint8_t>{50, 60, 70, 80}));
}

TEST(Ktx2, ChannelsAndSwizzle) {
  const auto of_channel = [](uint8_t channel) {
    Ktx2Builder builder = uastc_file();
    builder.channels = {channel};
    return texel(builder, 0);
  };
  EXPECT_EQ(of_channel(0), (std::vector<uint8_t>{10, 20, 30, 255}));
  EXPECT_EQ(of_channel(4), (std::vector<uint8_t>{10, 20, 30, 255}));
  EXPECT_EQ(of_channel(5), (std::vector<uint8_t>{10, 40, 0, 255}));
  EXPECT_EQ(of_channel(6), (std::vector<uint8_t>{10, 20, 0, 255}));
  Ktx2Builder builder = rgba_file();
  builder.pairs = {{"KTXswizzle", "b1r0"}, {"KTXwriter", "test"}};
  EXPECT_EQ(texel(builder, 0), (std::vector<uint8_t>{3, 255, 1, 0}));
  builder.pairs = {{"KTXswizzle", "rgbx"}};
  EXPECT_EQ(texel(builder, 0), (std::vector<uint8_t>{1, 2, 3, 4}));
}

TEST(Ktx2, OrientationIsNormalized) {
  struct Case {
    const char* orientation;
    std::vector<size_t> sources;
  };
  for (const Case& known : {Case{"rd", {0, 1, 2, 3, 4, 5}}, Case{"ru", {3, 4, 5, 0, 1, 2}},
                            Case{"ld", {2, 1, 0, 5, 4, 3}}, Case{"lu", {5, 4, 3, 2, 1, 0}}}) {
    Ktx2Builder builder = rgba_file();
    builder.pairs = {{"KTXorientation", known.orientation}};
    std::vector<uint8_t> expected;
    for (const size_t source : known.sources) {
      for (size_t c = 0; c < 4; ++c) expected.push_back(kTexels[4 * source + c]);
    }
    EXPECT_EQ(texels(builder), expected) << known.orientation;
    const Result<ImageHeader> header = read_image_header(builder.file());
    ASSERT_TRUE(header.ok());
    EXPECT_EQ(header->notes.empty(), known.sources[0] == 0) << known.orientation;
  }
}

TEST(Ktx2, EachFaultByName) {
  struct Fault {
    const char* expected;
    std::function<void(Ktx2Builder&)> plant;
  };
  const std::vector<Fault> faults{
      {"not a two-dimensional texture", [](auto& b) { b.width = 0; }},
      {"not a two-dimensional texture", [](auto& b) { b.height = 0; }},
      {"not a two-dimensional texture", [](auto& b) { b.depth = 2; }},
      {"not a two-dimensional texture", [](auto& b) { b.layers = 2; }},
      {"not a two-dimensional texture", [](auto& b) { b.faces = 6; }},
      {"has 33 mip levels", [](auto& b) { b.levels = 33; }},
      {"supercompression scheme is 3", [](auto& b) { b.scheme = 3; }},
      {"its blocks are not ETC1S", [](auto& b) { b.scheme = 1; }},
      {"its format is 97", [](auto& b) { b.format = 97; }},
      {"not compressed with BasisLZ",
       [](auto& b) {
         b.format = 0;
         b.model = 163;
         b.channels = {0};
       }},
      {"ETC1S blocks have unknown channels",
       [](auto& b) {
         b.format = 0;
         b.model = 163;
         b.scheme = 1;
         b.channels = {15, 0};
       }},
      {"UASTC blocks have unknown channels",
       [](auto& b) {
         b.format = 0;
         b.model = 166;
         b.channels = {9};
       }},
      {"its level 0 has 23 bytes, but needs 24", [](auto& b) { b.level.pop_back(); }},
      {"its Zstandard data is damaged", [](auto& b) { b.scheme = 2; }},
      {"its Zstandard data holds 23 bytes, but level 0 needs 24",
       [](auto& b) {
         b.scheme = 2;
         b.level.pop_back();
         b.level = compressed(b.level);
       }},
      {"its Zstandard data is damaged",  // more than the level
       [](auto& b) {
         b.scheme = 2;
         b.level.push_back(std::byte{0});
         b.level = compressed(b.level);
       }},
      {"its Zstandard data is cut short",  // a bomb
       [](auto& b) {
         b.scheme = 2;
         b.width = b.height = 1 << 14;
         b.level = compressed(b.level);
       }},
      {"its BasisLZ data is damaged",
       [](auto& b) {
         b.format = 0;
         b.model = 163;
         b.scheme = 1;
         b.channels = {0};
       }},
  };
  for (const Fault& fault : faults) {
    Ktx2Builder builder = rgba_file();
    fault.plant(builder);
    const Result<Image> image = decoded(builder.file());
    ASSERT_FALSE(image.ok()) << fault.expected;
    EXPECT_NE(image.error().message.find(fault.expected), std::string::npos) << image.error().message;
  }
  std::vector<std::byte> without_descriptor = rgba_file().file();
  without_descriptor[52] = std::byte{8};  // its length
  EXPECT_FALSE(decoded(without_descriptor).ok());
}

TEST(Ktx2, DamagedFilesAreRefusedOrDecoded) {
  Ktx2Builder zstandard = uastc_file();
  zstandard.scheme = 2;
  zstandard.level = compressed(zstandard.level);
  zstandard.pairs = {{"KTXorientation", "rd"}, {"KTXswizzle", "rgba"}};
  for (const Ktx2Builder& builder : {rgba_file(), uastc_file(), zstandard}) {
    const std::vector<std::byte> file = builder.file();
    const size_t refused =
        ktx2_test::count_refused_damages(file, [](bool is_right) { ASSERT_TRUE(is_right); });
    EXPECT_GT(refused, file.size());
  }
}

// A texture with a PNG as its own image and a KTX 2.0 file as the extension's.
GltfBuilder gltf_of(const Ktx2Builder& image) {
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(2, 1, 0xff336699));
  builder.add_textured_material(image.file());
  builder.root["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 1;
  builder.root["extensionsUsed"] = {"KHR_texture_basisu"};
  builder.root["textures"].erase(1);
  builder.root["materials"].erase(1);
  return builder;
}

TEST(Ktx2, TheExtensionPrecedesTheFallback) {
  Ktx2Builder image = uastc_file();
  image.transfer = 2;
  GltfBuilder builder = gltf_of(image);
  const Scene both = loaded(builder);
  EXPECT_TRUE(both.warnings.empty());
  ASSERT_EQ(both.images.size(), 1u);
  EXPECT_EQ(both.images[0].width, 6u);
  builder.root["extensionsRequired"] = {"KHR_texture_basisu"};
  builder.root["textures"][0].erase("source");
  EXPECT_EQ(loaded(builder).images[0].height, 3u);
  LoadLimits limits;
  limits.max_image_pixels = 17;
  const auto limited = load_glb(builder.glb(), "scene", limits);
  ASSERT_TRUE(limited.ok());
  ASSERT_EQ(limited->warnings.size(), 1u);
  EXPECT_TRUE(limited->warnings[0].starts_with("images[1]: it is 6 x 3 pixels large; at most 17 pixels"));
}

TEST(Ktx2, TheUseDecidesTheTransferFunction) {
  Ktx2Builder linear = uastc_file();
  const Scene scene = loaded(gltf_of(linear));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "images[1]: its transfer function is linear, but a material uses it as sRGB colours");
  EXPECT_TRUE(scene.textures[0].srgb);

  Ktx2Builder srgb = uastc_file();
  srgb.transfer = 2;
  GltfBuilder data = gltf_of(srgb);
  data.root["materials"][0] = {{"normalTexture", {{"index", 0}}}};
  const Scene data_scene = loaded(data);
  ASSERT_EQ(data_scene.warnings.size(), 1u);
  EXPECT_EQ(data_scene.warnings[0],
            "images[1]: its transfer function is sRGB, but a material uses it as data");
  EXPECT_FALSE(data_scene.textures[0].srgb);

  srgb.flags = 1;
  srgb.pairs = {{"KTXorientation", "ru"}};
  const Scene noted = loaded(gltf_of(srgb));
  ASSERT_EQ(noted.warnings.size(), 2u);
  EXPECT_NE(noted.warnings[0].find("KTXorientation"), std::string::npos);
  EXPECT_NE(noted.warnings[1].find("multiplied by alpha"), std::string::npos);
}

}  // namespace
}  // namespace fire3dv::scene
