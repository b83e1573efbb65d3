// Test of texture images that are missing, broken or too large: a placeholder and a warning, while limits of
// the whole load refuse it.
#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/textures/images.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

constexpr const char* kChecker = "; a magenta checker is shown instead";

GltfBuilder textured_file() {
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(2, 2, 0xff336699));
  builder.root["images"][0]["name"] = "bark";
  return builder;
}

// Expects that the image becomes a placeholder with this one warning.
void expect_placeholder(const GltfBuilder& builder, const std::string& warning,
                        const LoadLimits& limits = {}) {
  const test::ScratchFolder folder;
  const auto scene = load_gltf(folder.write("scene.glb", builder.glb()), limits);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_EQ(scene->warnings.size(), 1u);
  EXPECT_EQ(scene->warnings[0], warning);
  const TextureRef& ref = scene->materials[1].base_color_texture;
  ASSERT_NE(ref.texture, kNone);
  ASSERT_EQ(scene->images.size(), 1u);
  const Image& image = scene->images[scene->textures[ref.texture].image];
  EXPECT_EQ(image.rgba8, placeholder_image("").rgba8);
}

TEST(SceneImages, PlaceholderIsACheckerboard) {
  const Image image = placeholder_image("bark");
  EXPECT_EQ(image.name, "bark");
  ASSERT_EQ(image.width, 64u);
  ASSERT_EQ(image.height, 64u);
  const auto texel = [&](uint32_t x, uint32_t y) {
    const uint8_t* rgba = image.rgba8.data() + size_t{4} * (64 * y + x);
    return std::vector<uint8_t>(rgba, rgba + 4);
  };
  const std::vector<uint8_t> magenta{255, 0, 255, 255}, black{0, 0, 0, 255};
  EXPECT_EQ(texel(0, 0), magenta);
  EXPECT_EQ(texel(7, 7), magenta);
  EXPECT_EQ(texel(8, 7), black);
  EXPECT_EQ(texel(7, 8), black);
  EXPECT_EQ(texel(63, 63), magenta);
}

TEST(SceneImages, FaultsBecomePlaceholders) {
  struct Fault {
    const char* name;
    std::function<void(GltfBuilder&)> plant;
    std::string warning;
  };
  const std::vector<Fault> faults{
      {"missing file",
       [](auto& b) {
         b.root["images"][0] = {{"uri", "wood.png"}};
       },
       "images[0] \"wood.png\": cannot open \"wood.png\": No such file or directory"},
      {"path outside of the folder",
       [](auto& b) {
         b.root["images"][0] = {{"uri", "../wood.png"}};
       },
       "images[0] \"../wood.png\": the URI \"../wood.png\" leaves the asset's folder"},
      {"network address",
       [](auto& b) {
         b.root["images"][0] = {{"uri", "http://localhost/a.png"}};
       },
       "images[0] \"http://localhost/a.png\": the URI \"http://localhost/a.png\" has a scheme: only data: "
       "and "
       "relative paths are read"},
      {"another format",
       [](auto& b) {
         b.root["images"][0]["uri"] = "data:,GIF89a";
         b.root["images"][0].erase("bufferView");
       },
       "images[0] \"bark\": it is none of PNG, JPEG, WebP and KTX 2.0"},
      {"no bytes at all",
       [](auto& b) {
         b.root["images"][0] = {{"name", "bark"}};
       },
       "images[0] \"bark\": it has neither a uri nor a bufferView"},
      {"broken base64",
       [](auto& b) {
         b.root["images"][0] = {{"uri", "data:image/png;base64,AAA!"}};
       },
       "images[0]: its base64 text holds a character that is not base64"},
      {"view beyond the buffer", [](auto& b) { b.root["bufferViews"].back()["byteLength"] = 100000; },
       "images[0] \"bark\": bufferViews[2] reaches from byte"},
  };
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.name);
    GltfBuilder builder = textured_file();
    fault.plant(builder);
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(scene.warnings[0].starts_with(fault.warning)) << scene.warnings[0];
    EXPECT_TRUE(scene.warnings[0].ends_with(kChecker)) << scene.warnings[0];
    expect_placeholder(builder, scene.warnings[0]);
  }
}

TEST(SceneImages, DamagedFilesArePlaceholders) {
  std::vector<std::byte> cut_short = test::png(64, 64, 7);
  cut_short.resize(60);
  std::vector<std::byte> huge_header = test::png(1, 1, 0);
  huge_header[16] = huge_header[20] = std::byte{0};
  huge_header[17] = huge_header[21] = std::byte{1};
  for (const auto& [image, reason] : {std::pair(cut_short, "it cannot be decoded: "),
                                      std::pair(huge_header, "its header cannot be read: ")}) {
    GltfBuilder builder = test::triangle_file();
    builder.add_textured_material(image);
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(scene.warnings[0].starts_with(std::string("images[0]: ") + reason)) << scene.warnings[0];
    expect_placeholder(builder, scene.warnings[0]);
  }
}

TEST(SceneImages, PixelLimitIsEnforced) {
  GltfBuilder builder = test::triangle_file();
  builder.add_textured_material(test::png(8, 8, 0));
  LoadLimits limits;
  limits.max_image_pixels = 63;
  expect_placeholder(
      builder, std::string("images[0]: it is 8 x 8 pixels large; at most 63 pixels are read") + kChecker,
      limits);
  limits.max_image_pixels = 64;
  const auto scene = load_glb(builder.glb(), "scene", limits);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene->images[0].width, 8u);
  EXPECT_TRUE(scene->warnings.empty());
}

// A checker of magenta as normal map or as roughness looks like another material; without the texture the
// factors remain.
TEST(SceneImages, DataPlaceholdersAreSkipped) {
  GltfBuilder builder = textured_file();
  builder.root["images"][0] = {{"uri", "wood.png"}};
  json& material = builder.root["materials"][0];
  material["normalTexture"] = {{"index", 0}, {"texCoord", 1}};
  material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
  material["occlusionTexture"] = {{"index", 0}};
  material["emissiveTexture"] = {{"index", 0}};
  material["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"] = {{"index", 0}};
  builder.root["extensionsUsed"] = {"KHR_materials_clearcoat"};
  const Scene scene = loaded(builder);
  const Material& loaded_material = scene.materials[1];
  EXPECT_NE(loaded_material.base_color_texture.texture, kNone);
  EXPECT_NE(loaded_material.emissive_texture.texture, kNone);
  for (const TextureRef* ref :
       {&loaded_material.normal_texture, &loaded_material.metallic_roughness_texture,
        &loaded_material.occlusion_texture, &loaded_material.clearcoat_normal_texture}) {
    EXPECT_EQ(ref->texture, kNone);
    EXPECT_EQ(ref->uv_set, 0u);
  }
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_TRUE(scene.warnings[0].ends_with(std::string(kChecker) + ", and other uses are left out"));

  material.erase("emissiveTexture");
  material["pbrMetallicRoughness"].erase("baseColorTexture");
  const Scene data_only = loaded(builder);
  ASSERT_EQ(data_only.warnings.size(), 1u);
  EXPECT_TRUE(data_only.warnings[0].ends_with("No such file or directory; it is left out"));
}

TEST(SceneImages, OtherImagesAreRead) {
  GltfBuilder builder = textured_file();
  builder.add_textured_material({});
  builder.add_textured_material(test::png(5, 1, 0xff00ff00));
  builder.root["images"][1] = {{"uri", "wood.png"}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.images.size(), 3u);
  EXPECT_EQ(scene.images[0].width, 2u);
  EXPECT_EQ(scene.images[1].width, 64u);
  EXPECT_EQ(scene.images[2].width, 5u);
  EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(SceneImages, ViewPrecedesUri) {
  GltfBuilder builder = textured_file();
  builder.root["images"][0]["uri"] = "missing.png";
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.images[0].width, 2u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "images[0] has both a uri and a bufferView; the bufferView is read");
}

TEST(SceneImages, LoadLimitsStillRefuse) {
  GltfBuilder builder = textured_file();
  builder.add_textured_material({});
  builder.root["images"][1] = {{"uri", "wood.png"}};
  LoadLimits limits;
  limits.reserve = [](uint64_t bytes) {
    return bytes == 16 ? Result<void>(Error{"no room"}) : Result<void>();
  };
  const auto refused = load_glb(builder.glb(), "scene", limits);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "scene: the images have 4 pixels: no room");

  limits = {};
  int polls = 0;
  limits.stop_requested = [&] { return ++polls > 0; };
  builder.root.erase("meshes");
  builder.root.erase("nodes");
  builder.root["scenes"] = json::array({json::object()});
  const auto stopped = load_glb(builder.glb(), "scene", limits);
  ASSERT_FALSE(stopped.ok());
  EXPECT_NE(stopped.error().message.find("stopped"), std::string::npos) << stopped.error().message;
}

}  // namespace
}  // namespace fire3dv::scene
