// Test of WebP textures: pixels as libwebp's encoder got them, EXT_texture_webp, limits and damaged files.
#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "renderer/scene/textures/image_codecs.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using test::GltfBuilder;

std::vector<uint8_t> gradient(int width, int height) {
  std::vector<uint8_t> rgba;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {x * 255 / width, y * 255 / height, 64, 255 - x * 200 / width})
        rgba.push_back(static_cast<uint8_t>(value));
    }
  }
  return rgba;
}

// quality: -1 for lossless.
std::vector<std::byte> webp(const std::vector<uint8_t>& rgba, int width, int height, float quality = -1) {
  uint8_t* encoded = nullptr;
  const size_t size = quality < 0 ? WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &encoded)
                                  : WebPEncodeRGBA(rgba.data(), width, height, 4 * width, quality, &encoded);
  std::vector<std::byte> bytes(size);
  std::memcpy(bytes.data(), encoded, size);
  WebPFree(encoded);
  return bytes;
}

// A texture with a PNG of 2 x 1 texels as its own image, and a WebP of 4 x 3 as the extension's.
GltfBuilder file_with_both() {
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(2, 1, 0xff336699));
  builder.add_textured_material(webp(gradient(4, 3), 4, 3));
  builder.root["images"][1]["mimeType"] = "image/webp";
  builder.root["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  builder.root["extensionsUsed"] = {"EXT_texture_webp"};
  builder.root["textures"].erase(1);
  builder.root["materials"].erase(1);
  return builder;
}

TEST(SceneWebp, LosslessPixelsAreExact) {
  const std::vector<uint8_t> rgba = gradient(37, 19);
  const std::vector<std::byte> bytes = webp(rgba, 37, 19);
  const Result<ImageHeader> header = read_image_header(bytes);
  ASSERT_TRUE(header.ok()) << header.error().message;
  EXPECT_EQ(header->width, 37u);
  EXPECT_EQ(header->height, 19u);
  const Result<Image> image = decode_image(*header, bytes);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(std::vector<uint8_t>(image->rgba8.begin(), image->rgba8.end()), rgba);
}

TEST(SceneWebp, LossyPixelsAreNear) {
  const std::vector<uint8_t> rgba = gradient(64, 64);
  const std::vector<std::byte> bytes = webp(rgba, 64, 64, 95);
  const Result<Image> image = decode_image(*read_image_header(bytes), bytes);
  ASSERT_TRUE(image.ok()) << image.error().message;
  int greatest = 0;
  for (size_t i = 0; i < rgba.size(); ++i) {
    if (rgba[i / 4 * 4 + 3] < 128) continue;  // colours below transparency are coarser
    greatest = std::max(greatest, std::abs(int{rgba[i]} - int{image->rgba8[i]}));
  }
  EXPECT_LE(greatest, 16);
}

TEST(SceneWebp, TheExtensionPrecedesTheFallback) {
  const Scene both = loaded(file_with_both());
  EXPECT_TRUE(both.warnings.empty());
  ASSERT_EQ(both.images.size(), 1u);
  EXPECT_EQ(both.images[0].width, 4u);

  GltfBuilder required = file_with_both();
  required.root["extensionsRequired"] = {"EXT_texture_webp"};
  required.root["textures"][0].erase("source");
  const Scene alone = loaded(required);
  ASSERT_EQ(alone.images.size(), 1u);
  EXPECT_EQ(alone.images[0].height, 3u);
  EXPECT_NE(alone.materials[1].base_color_texture.texture, kNone);

  GltfBuilder empty = file_with_both();
  empty.root["textures"][0]["extensions"]["EXT_texture_webp"] = nlohmann::json::object();
  EXPECT_EQ(loaded(empty).images[0].width, 2u);

  GltfBuilder by_content = file_with_both();
  by_content.root["textures"][0] = {{"source", 1}};
  by_content.root["images"][1].erase("mimeType");
  EXPECT_EQ(loaded(by_content).images[0].width, 4u);

  GltfBuilder missing = file_with_both();
  missing.root["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 2;
  const auto refused = load(missing);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("textures[0].extensions.EXT_texture_webp refers to images[2]"),
            std::string::npos)
      << refused.error().message;
}

TEST(SceneWebp, PixelsAreLimitedBeforeDecoding) {
  LoadLimits limits;
  limits.max_image_pixels = 11;
  const auto scene = load_glb(file_with_both().glb(), "scene", limits);
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_TRUE(scene->warnings[0].starts_with("images[1]: it is 4 x 3 pixels large; at most 11 pixels"));
}

TEST(SceneWebp, AnAnimationIsNoTexture) {
  // Extended header with the animation flag, for a canvas of 1 x 1.
  const std::string header = std::string("RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\0\0\0\0\0\0", 30);
  const Result<ImageHeader> read = read_image_header(std::as_bytes(std::span(header)));
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("animation"), std::string::npos) << read.error().message;
}

TEST(SceneWebp, DamagedFilesAreSafe) {
  for (const float quality : {-1.0f, 80.0f}) {
    const std::vector<std::byte> good = webp(gradient(24, 17), 24, 17, quality);
    size_t refused = 0;
    const auto decode = [&](std::span<const std::byte> bytes) {
      const Result<ImageHeader> header = read_image_header(bytes);
      if (!header || header->pixels() > 1u << 20 || !decode_image(*header, bytes)) ++refused;
    };
    for (size_t size = 0; size < good.size(); ++size) decode(std::span(good).first(size));
    EXPECT_GT(refused, good.size() / 2);
    for (size_t i = 0; i < good.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        std::vector<std::byte> bytes = good;
        bytes[i] ^= static_cast<std::byte>(1 << bit);
        decode(bytes);
      }
    }
  }
}

}  // namespace
}  // namespace fire3dv::scene
