// Test of exported scenes: the loader reads back what was edited, bit by bit, and everything else as in the
// file; what glTF cannot express is reported; a file that has changed is refused.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/scene/gltf/export/export_glb.h"
#include "renderer/scene/gltf/gltf_container.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

// "arm" with "hand" and "lamp" below it, and a free "floor" without a material.
test::GltfBuilder arm_file() {
  test::GltfBuilder builder;
  const size_t material = builder.add_textured_material(test::png(2, 2, 0xff2080c0));
  builder.root["materials"][material]["name"] = "steel";
  const size_t mesh = builder.add_triangle_mesh(), plain = builder.add_triangle_mesh();
  builder.root["meshes"][mesh]["primitives"][0]["material"] = material;
  const size_t arm = builder.add_node("arm", {{"mesh", mesh}, {"translation", {1, 2, 3}}});
  builder.add_child(arm, "hand",
                    {{"mesh", mesh}, {"matrix", {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1}}});
  builder.add_child(arm, "lamp", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.add_node("floor", {{"mesh", plain}});
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 3}}};
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  return builder;
}

class Exports : public ::testing::Test {
 protected:
  Scene load(const ExportedGlb& exported) {
    Result<Scene> scene = load_glb(exported.bytes, "exported");
    EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
    return scene.ok() ? std::move(*scene) : Scene();
  }
  ExportedGlb exported(const ExportedEdits& edits) {
    Result<ExportedGlb> made = export_glb(file_, edits);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
    return made.ok() ? std::move(*made) : ExportedGlb();
  }
  static void expect_same_geometry(const Scene& a, const Scene& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.frames, b.frames);
    EXPECT_EQ(a.uvs, b.uvs);
    ASSERT_EQ(a.images.size(), b.images.size());
    for (size_t i = 0; i < a.images.size(); ++i) EXPECT_EQ(a.images[i].rgba8, b.images[i].rgba8);
  }

  test::ScratchFolder folder_;
  std::filesystem::path file_ = folder_.write("arm.glb", arm_file().glb());
  Scene scene_ = *load_gltf(file_);
};

TEST_F(Exports, FileWithoutEditsIsSameScene) {
  const ExportedGlb made = exported({});
  EXPECT_TRUE(made.warnings.empty());
  const Scene again = load(made);
  expect_same_geometry(again, scene_);
  ASSERT_EQ(again.nodes.size(), scene_.nodes.size());
  for (size_t i = 0; i < again.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].path, scene_.nodes[i].path);
    EXPECT_EQ(again.nodes[i].world_from_node, scene_.nodes[i].world_from_node);
  }
}

TEST_F(Exports, BuffersAndImagesAreEmbedded) {
  test::GltfBuilder builder = arm_file();
  folder_.write("part/arm.bin", builder.bin);
  folder_.write("part/skin.png", test::png(2, 2, 0xff2080c0));
  builder.root["images"][0] = {{"uri", "part/skin.png"}};
  file_ = folder_.write("arm.gltf", builder.gltf("part/arm.bin"));
  const ExportedGlb made = exported({});
  EXPECT_TRUE(made.warnings.empty());
  expect_same_geometry(load(made), *load_gltf(file_));
  // A name that leads out of the folder is not followed.
  builder.root["images"][0] = {{"uri", "../secret.png"}};
  file_ = folder_.write("sub/arm.gltf", builder.gltf(test::data_uri(builder.bin)));
  folder_.write("secret.png", test::png(1, 1, 0));
  EXPECT_EQ(exported({}).warnings.size(), 1u);
}

TEST_F(Exports, TransformsRoundTripExactly) {
  ExportedEdits edits;
  const glm::quat turn = glm::angleAxis(0.7f, glm::normalize(glm::vec3(1, -2, 0.5f)));
  ExportedTransform& arm = edits.transforms[0];
  arm = {parent_from_parts({0.1f, 1e-7f, -3.3f}, turn, {1, 1.1f, -2}),
         true,
         {0.1f, 1e-7f, -3.3f},
         turn,
         {1, 1.1f, -2}};
  ExportedTransform& hand = edits.transforms[1];
  hand.parent_from_node = glm::mat4(1, 0.2f, 0, 0, 0.1f, 1.3f, 0, 0, 0, 0, 1, 0, 1 / 3.0f, 2, 3, 1);
  const Scene again = load(exported(edits));
  EXPECT_EQ(again.nodes[0].parent_from_node, arm.parent_from_node);
  EXPECT_EQ(again.nodes[1].parent_from_node, hand.parent_from_node);
  EXPECT_EQ(again.nodes[1].world_from_node, arm.parent_from_node * hand.parent_from_node);
  EXPECT_EQ(again.nodes[3].parent_from_node, scene_.nodes[3].parent_from_node);
  expect_same_geometry(again, scene_);
}

TEST_F(Exports, VariantBecomesDefaultAndOthersStay) {
  test::GltfBuilder builder = arm_file();
  const json mappings = {{{"material", 1}, {"variants", {0}}}, {{"material", 2}, {"variants", {1, 2}}}};
  for (const char* const name : {"red", "blue"}) builder.root["materials"].push_back({{"name", name}});
  for (const size_t mesh : {0, 1})  // the second one has no material of its own
    builder.root["meshes"][mesh]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] =
        mesh == 0 ? mappings : json{mappings[0]};
  builder.root["extensions"]["KHR_materials_variants"]["variants"] = {
      {{"name", "day"}}, {{"name", "night"}}, {{"name", "fog"}}};
  builder.root["extensionsUsed"].push_back("KHR_materials_variants");
  file_ = folder_.write("variants.glb", builder.glb());
  const auto materials = [&](uint32_t variant) {
    ExportedEdits edits;
    edits.variant = variant;
    const ExportedGlb made = exported(edits);
    EXPECT_TRUE(made.warnings.empty());
    const Scene again = load(made);
    EXPECT_EQ(again.variants, (std::vector<std::string>{"day", "night", "fog"}));
    std::vector<uint32_t> shown;
    for (const Primitive& primitive : again.primitives) {
      shown.push_back(primitive.material);
      shown.push_back(again.variant_materials[primitive.first_variant_material + 1]);  // of "day"
    }
    return shown;
  };
  EXPECT_EQ(materials(kNone), (std::vector<uint32_t>{1, 2, 0, 2}));
  EXPECT_EQ(materials(0), (std::vector<uint32_t>{2, 2, 2, 2}));
  EXPECT_EQ(materials(2), (std::vector<uint32_t>{3, 2, 0, 2}));
}

TEST_F(Exports, MaterialsAndLightsRoundTrip) {
  ExportedEdits edits;
  MaterialFactors steel = factors_of(scene_.materials[1]);
  steel.base_color = {0.1f, 0.2f, 1 / 3.0f, 1};
  steel.emissive = {0.3f, 17.7f, 1e-3f};  // with a strength
  steel.metallic = 0.7f;
  steel.roughness = 1 / 7.0f;
  edits.materials[1] = steel;
  MaterialFactors none = factors_of(scene_.materials[0]);
  none.base_color = {1, 0, 0, 1};
  edits.materials[0] = none;
  Light spot;
  spot.type = LightType::spot;
  spot.color = {1, 0.9f, 0.8f};
  spot.intensity = 123.4f;
  spot.range_m = 7.7f;
  spot.radius_m = 0.05f;
  spot.inner_cone_rad = 0.3f;
  spot.outer_cone_rad = 0.9f;
  edits.lights[2] = spot;
  const ExportedGlb made = exported(edits);
  EXPECT_TRUE(made.warnings.empty());
  const Scene again = load(made);
  EXPECT_EQ(factors_of(again.materials[1]), steel);
  ASSERT_EQ(again.materials.size(), scene_.materials.size() + 1);
  EXPECT_EQ(factors_of(again.materials.back()).base_color, none.base_color);
  EXPECT_EQ(again.primitives[again.meshes[again.nodes[3].mesh].first_primitive].material,
            again.materials.size() - 1);
  EXPECT_EQ(again.lights[again.nodes[2].light], spot);
  expect_same_geometry(again, scene_);
}

// As the merged scene has them: the copy of "arm", a light below "hand", a camera.
TEST_F(Exports, AddedNodesRoundTrip) {
  ExportedEdits edits;
  const uint32_t first = static_cast<uint32_t>(scene_.nodes.size());
  edits.added = {{first, kNone, "arm.1", 0}, {first + 1, first, {}, 1}, {first + 2, first, {}, 2}};
  Light spot;
  spot.type = LightType::spot;
  spot.intensity = 0.1f;
  ExportedNode lamp{first + 3, 1, "lamp.1"};
  lamp.light = spot;
  edits.added.push_back(lamp);
  ExportedNode view{first + 4, kNone, "view"};
  view.camera.emplace();
  view.camera->vertical_fov_rad = 0.7f;
  view.camera->near_m = 0.03f;
  view.camera->lens = {2.8f, 1.1f};
  edits.added.push_back(view);
  ExportedNode part{first + 5, kNone, "part"};
  part.asset.emplace();
  edits.added.push_back(part);
  edits.added.push_back({first + 6, kNone, "of a stream", 99});
  edits.transforms[first].parent_from_node = glm::mat4(2);
  edits.transforms[first].parent_from_node[3] = {5, 0, 0, 1};
  edits.lights[2].intensity = 77;  // not that of the copy
  edits.hidden = {first + 1};
  const ExportedGlb made = exported(edits);
  ASSERT_EQ(made.warnings.size(), 2u);
  EXPECT_NE(made.warnings[0].find("\"part\""), std::string::npos) << made.warnings[0];
  const Scene again = load(made);
  const auto node = [&](const std::string& path) {
    const auto found = std::ranges::find(again.nodes, path, &Node::path);
    EXPECT_NE(found, again.nodes.end()) << path;
    return found == again.nodes.end() ? Node() : *found;
  };
  ASSERT_EQ(again.nodes.size(), scene_.nodes.size() + 5);
  EXPECT_EQ(node("arm.1").parent_from_node, edits.transforms[first].parent_from_node);
  EXPECT_EQ(node("arm.1").mesh, again.nodes[0].mesh) << "by reference";
  for (const char* const name : {"arm", "hand", "lamp", "floor"})
    EXPECT_EQ(std::ranges::count(again.nodes, name, &Node::name), 1) << name << ": streams find it by name";
  EXPECT_EQ(node("arm.1/hand (arm.1)").parent_from_node, scene_.nodes[1].parent_from_node);
  EXPECT_EQ(node("arm.1/hand (arm.1)").mesh, kNone) << "hidden";
  EXPECT_NE(node("arm/hand").mesh, kNone);
  EXPECT_EQ(again.lights.at(node("arm.1/lamp (arm.1)").light).intensity, 3);
  EXPECT_EQ(again.lights.at(node("arm/lamp").light).intensity, 77);
  EXPECT_EQ(again.lights.at(node("arm/hand/lamp.1").light), spot);
  EXPECT_EQ(again.cameras.at(node("view").camera), *view.camera);
  expect_same_geometry(again, scene_);
}

// A skin of a copy follows the joints of the copy, if it has them all.
TEST_F(Exports, CopiedSkinsHaveJoints) {
  test::GltfBuilder builder = arm_file();
  builder.root["skins"] = {{{"joints", {1, 2}}}, {{"joints", {3}}}};
  builder.root["nodes"][0]["skin"] = 0;
  builder.root["nodes"][1]["skin"] = 1;
  file_ = folder_.write("skinned.glb", builder.glb());
  ExportedEdits edits;
  edits.added = {{4, kNone, "arm.1", 0}, {5, 4, {}, 1}, {6, 4, {}, 2}};
  const ExportedGlb made = exported(edits);
  const json root = json::parse(open_container(folder_.write("made.glb", made.bytes), {}).value().json);
  EXPECT_EQ(root["skins"].size(), 3u);
  EXPECT_EQ(root["nodes"][4]["skin"], 2);
  EXPECT_EQ(root["skins"][2]["joints"], json({5, 6}));
  EXPECT_EQ(root["nodes"][5]["skin"], 1);
  EXPECT_EQ(root["nodes"][0]["skin"], 0);
}

// Ours keeps the lights of hidden nodes, glTF does not.
TEST_F(Exports, HiddenNodesKeepLights) {
  ExportedEdits edits;
  edits.hidden = {0};
  Scene again = load(exported(edits));
  for (const Node& node : again.nodes) {
    EXPECT_EQ(node.mesh != kNone, node.name == "floor") << node.path;
    EXPECT_EQ(node.light != kNone, node.name == "lamp") << node.path;
  }
  edits.hidden = {};
  edits.removed = {0};
  again = load(exported(edits));
  EXPECT_EQ(again.nodes[2].light, kNone);
  EXPECT_EQ(again.nodes[1].mesh, kNone);
  EXPECT_NE(again.nodes[3].mesh, kNone);
}

TEST_F(Exports, MissingObjectsAreReported) {
  ExportedEdits edits;
  edits.transforms[17] = {};
  edits.materials[9] = {};
  edits.lights[2].casts_shadow = false;
  const ExportedGlb made = exported(edits);
  EXPECT_EQ(made.warnings.size(), 3u);
  edits = {};
  edits.names[1] = "foot";
  const Result<ExportedGlb> changed = export_glb(file_, edits);
  ASSERT_FALSE(changed.ok());
  EXPECT_NE(changed.error().message.find("has changed"), std::string::npos) << changed.error().message;
  for (const char* text : {"", "{", "{}", R"({"nodes": [{"children": [0]}], "scenes": [{"nodes": [0]}]})",
                           R"({"nodes": [{"children": [7]}]})", R"({"buffers": [{"uri": 3}]})",
                           R"({"nodes": 3, "scenes": [{"nodes": [1]}]})", R"({"materials": {"a": 1}})"}) {
    file_ = folder_.write("damaged.gltf", std::string_view(text));
    ExportedEdits some;
    some.hidden = {0};
    some.materials[1] = {};
    const Result<ExportedGlb> read = export_glb(file_, some);
    const bool is_refused = !read.ok() || !load_glb(read->bytes, "damaged").ok();
    EXPECT_TRUE(is_refused) << text;
  }
}

}  // namespace
}  // namespace fire3dv::scene
