// Test of extensions that the loader leaves out or refuses, and of KHR_node_visibility.
#include "renderer/scene/gltf/gltf_extensions.h"

#include <gtest/gtest.h>

#include <string>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;

GltfBuilder with_extensions(const char* member, json names) {
  GltfBuilder builder = test::triangle_file();
  builder.root[member] = std::move(names);
  return builder;
}

TEST(SceneExtensions, RequiredAppearanceIsWarned) {
  for (const char* name : {"KHR_materials_volume_scatter", "VENDOR_materials_glitter", "EXT_texture_avif",
                           "EXT_lights_image_based", "EXT_lights_ies", "KHR_xmp", "KHR_xmp_json_ld",
                           "KHR_animation_pointer", "KHR_node_selectability", "MSFT_lod", "KHR_audio_emitter",
                           "KHR_physics_rigid_bodies", "VRMC_springBone"}) {
    const Scene scene = loaded(with_extensions("extensionsRequired", {name}));
    EXPECT_EQ(scene.primitives.size(), 1u);
    ASSERT_EQ(scene.warnings.size(), 1u) << name;
    EXPECT_NE(scene.warnings[0].find('"' + std::string(name) + "\" ("), std::string::npos)
        << scene.warnings[0];
  }
}

TEST(SceneExtensions, RequiredGeometryIsRefused) {
  for (const char* name : {"KHR_gaussian_splatting", "EXT_mesh_primitive_restart", "KHR_accessor_float64",
                           "MPEG_accessor_timed", "VENDOR_terrain", "KHR_draco_point_compression"}) {
    const auto scene = load(with_extensions("extensionsRequired", {name}));
    ASSERT_FALSE(scene.ok()) << name;
    const std::string& error = scene.error().message;
    EXPECT_NE(error.find("scene.glb: the file requires the extension \"" + std::string(name)),
              std::string::npos)
        << error;
    EXPECT_NE(error.find("export the file without it"), std::string::npos);
  }
}

TEST(SceneExtensions, UsedExtensionsAreOneWarning) {
  const json names{"VENDOR_terrain", "KHR_materials_ior", "KHR_materials_volume_scatter", "VENDOR_terrain"};
  GltfBuilder builder = with_extensions("extensionsUsed", names);
  builder.root["extensionsRequired"] = {"KHR_materials_volume_scatter"};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "extensions that are not supported are left out: \"VENDOR_terrain\", "
            "\"KHR_materials_volume_scatter\" (no light scatters inside objects)");
  EXPECT_TRUE(loaded(with_extensions("extensionsUsed", json::array())).warnings.empty());
}

TEST(SceneExtensions, WrongTypesAreErrors) {
  EXPECT_FALSE(load(with_extensions("extensionsUsed", "KHR_xmp")).ok());
  EXPECT_FALSE(load(with_extensions("extensionsRequired", {3})).ok());
}

TEST(SceneExtensions, PointerChannelsWarnOnce) {
  GltfBuilder builder = with_extensions("extensionsUsed", {"KHR_animation_pointer"});
  const size_t times = builder.add_data(std::vector<float>{0, 1}, "SCALAR", test::kFloat, 1);
  json channel{{"sampler", 0},
               {"target",
                {{"path", "pointer"},
                 {"extensions", {{"KHR_animation_pointer", {{"pointer", "/materials/0/alphaCutoff"}}}}}}}};
  builder.root["animations"] = {
      {{"samplers", {{{"input", times}, {"output", times}}}}, {"channels", {channel, channel, channel}}}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("\"KHR_animation_pointer\" (only nodes and morph weights are animated)"),
            std::string::npos);
}

// Hidden nodes keep their place and camera, without meshes and lights, with all below them.
TEST(SceneExtensions, NodeVisibility) {
  const auto visibility = [](bool visible) { return json{{"KHR_node_visibility", {{"visible", visible}}}}; };
  GltfBuilder builder;
  const size_t mesh = builder.add_triangle_mesh();
  builder.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  json light = visibility(true);
  light["KHR_lights_punctual"] = {{"light", 0}};
  const size_t hidden = builder.add_node("hidden", {{"mesh", mesh}, {"extensions", visibility(false)}});
  builder.add_child(hidden, "below", {{"mesh", mesh}, {"camera", 0}, {"extensions", light}});
  builder.add_node("shown", {{"mesh", mesh}, {"extensions", visibility(true)}});
  builder.add_node("default", {{"mesh", mesh}, {"extensions", {{"KHR_node_visibility", json::object()}}}});
  builder.root["extensionsRequired"] = {"KHR_node_visibility", "KHR_lights_punctual"};
  const Scene scene = loaded(builder);
  EXPECT_TRUE(scene.warnings.empty());
  ASSERT_EQ(scene.nodes.size(), 4u);
  for (const Node& node : scene.nodes) {
    const bool is_hidden = node.path.starts_with("hidden");
    EXPECT_EQ(node.mesh == kNone, is_hidden) << node.path;
    EXPECT_EQ(node.light, kNone) << node.path;
  }
  EXPECT_EQ(scene.nodes[1].path, "hidden/below");
  EXPECT_EQ(scene.nodes[1].camera, 0u);
  builder.root["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"] = 0;
  EXPECT_FALSE(load(builder).ok());
}

}  // namespace
}  // namespace fire3dv::scene
