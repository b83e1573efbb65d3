// Test of exported scenes with added glTF files: the loader reads back the nodes, materials, textures, lights
// and cameras of the merged scene, with edits; files that are missing, damaged or changed are left out.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/digest.h"
#include "renderer/scene/derived/loaded_scene.h"
#include "renderer/scene/gltf/export/export_glb.h"
#include "renderer/scene/gltf/gltf_container.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;

// "arm" with a texture, and "lamp".
test::GltfBuilder arm_with_assets() {
  test::GltfBuilder builder;
  const size_t material = builder.add_textured_material(test::png(2, 2, 0xff2080c0));
  const size_t mesh = builder.add_triangle_mesh();
  builder.root["meshes"][mesh]["primitives"][0]["material"] = material;
  builder.root["samplers"] = {{{"wrapT", 33648}}};
  builder.root["textures"][0]["sampler"] = 0;
  builder.add_node("arm", {{"mesh", mesh}, {"translation", {1, 2, 3}}});
  builder.add_node("lamp", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 3}}};
  builder.root["extensionsUsed"] = {"KHR_lights_punctual"};
  return builder;
}

// "top" with "leg", "lamp" and "view" below it. The material of "top" has a texture, and another one in an
// extension; "leg" has none. "spare" is not displayed, but the parent of a displayed node.
test::GltfBuilder table_file() {
  test::GltfBuilder builder;
  const size_t wood = builder.add_textured_material(test::png(2, 2, 0xff00c040));
  builder.add_textured_material(test::png(1, 2, 0xff808080));
  builder.root["samplers"] = {{{"wrapS", 33071}}};
  builder.root["textures"][1]["sampler"] = 0;
  json& material = builder.root["materials"][wood];
  material["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 1},
                                                       {"clearcoatTexture", {{"index", 1}}}};
  material["extensions"]["EXT_unknown"] = {{"otherTexture", {{"index", 77}}}};
  const size_t top = builder.add_mesh(
      {{"attributes",
        {{"POSITION", builder.add_positions({0, 0, 0, 5, 0, 0, 0, 5, 0})},
         {"TEXCOORD_0", builder.add_data<float>({0, 0, 1, 0, 0, 1}, "VEC2", test::kFloat, 2)}}},
       {"material", wood},
       {"extensions", {{"KHR_materials_variants", {{"mappings", {{{"material", 1}, {"variants", {0}}}}}}}}}});
  const size_t leg = builder.add_triangle_mesh();
  const size_t node = builder.add_node("top", {{"mesh", top}, {"rotation", {0.6, 0, 0, 0.8}}});
  builder.add_child(node, "leg", {{"mesh", leg}, {"translation", {0, 0.1, 0}}});
  builder.add_child(node, "lamp", {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.add_child(node, "view", {{"camera", 0}, {"scale", {1, 2, 1}}});
  builder.root["nodes"].push_back({{"name", "spare"}, {"children", {node}}});
  builder.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}}}}};
  builder.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"intensity", 9}, {"spot", {{"outerConeAngle", 0.5}}}}};
  builder.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "day"}}};
  builder.root["extensionsUsed"] = {"KHR_lights_punctual", "KHR_materials_clearcoat",
                                    "KHR_materials_variants", "EXT_unknown"};
  return builder;
}

class ExportedAssets : public ::testing::Test {
 protected:
  // Adds the table as the displayed scene does.
  ExportedNode add_table(const std::string& name, uint32_t parent) {
    const glm::mat4 place = parent_from_parts({0.1f, -7, 2}, glm::quat(1, 0, 0, 0), glm::vec3(3));
    ExportedNode node{add_node(merged_.scene, name, parent, place), parent, name};
    node.asset = ExportedAsset{table_path_, static_cast<uint32_t>(table_.scene.nodes.size()),
                               static_cast<uint32_t>(merged_.scene.materials.size()),
                               static_cast<uint32_t>(table_.scene.materials.size()), table_digest_};
    EXPECT_TRUE(add_below(merged_, table_, node.node).ok());
    edits_.transforms[node.node].parent_from_node = place;
    return node;
  }
  ExportedGlb exported() {
    Result<ExportedGlb> made = export_glb(file_, edits_);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
    return made.ok() ? std::move(*made) : ExportedGlb();
  }
  static Scene load(const ExportedGlb& made) {
    Result<Scene> scene = load_glb(made.bytes, "exported");
    EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error().message);
    return scene.ok() ? std::move(*scene) : Scene();
  }
  static void expect_same_texture(const Scene& a, const TextureRef& of_a, const Scene& b,
                                  const TextureRef& of_b) {
    ASSERT_EQ(of_a.texture == kNone, of_b.texture == kNone);
    if (of_a.texture == kNone) return;
    const Texture &first = a.textures.at(of_a.texture), &second = b.textures.at(of_b.texture);
    EXPECT_EQ(first.sampler, second.sampler);
    EXPECT_EQ(a.images.at(first.image).rgba8, b.images.at(second.image).rgba8);
    EXPECT_EQ(a.images.at(first.image).width, b.images.at(second.image).width);
  }
  // Of the meshes of two nodes.
  static void expect_same_primitives(const Scene& a, const Node& of_a, const Scene& b, const Node& of_b) {
    ASSERT_EQ(of_a.mesh == kNone, of_b.mesh == kNone) << of_a.path;
    if (of_a.mesh == kNone) return;
    const Primitive& first = a.primitives.at(a.meshes.at(of_a.mesh).first_primitive);
    const Primitive& second = b.primitives.at(b.meshes.at(of_b.mesh).first_primitive);
    ASSERT_EQ(first.index_count, second.index_count);
    for (uint32_t i = 0; i < first.index_count; ++i) {
      const uint32_t vertex = first.first_vertex + a.indices.at(first.first_index + i);
      const uint32_t other = second.first_vertex + b.indices.at(second.first_index + i);
      EXPECT_EQ(a.positions.at(vertex), b.positions.at(other)) << of_a.path;
      EXPECT_EQ(a.frames.at(vertex), b.frames.at(other)) << of_a.path;
    }
    const Material &left = a.materials.at(first.material), &right = b.materials.at(second.material);
    EXPECT_EQ(left.name, right.name);
    EXPECT_EQ(left.clearcoat, right.clearcoat);
    expect_same_texture(a, left.base_color_texture, b, right.base_color_texture);
    expect_same_texture(a, left.clearcoat_texture, b, right.clearcoat_texture);
  }
  MaterialFactors factors(const Scene& scene, const std::string& path) const {
    const auto node = std::ranges::find(scene.nodes, path, &Node::path);
    return factors_of(
        scene.materials.at(scene.primitives.at(scene.meshes.at(node->mesh).first_primitive).material));
  }

  test::ScratchFolder folder_;
  std::filesystem::path file_ = folder_.write("arm.glb", arm_with_assets().glb());
  std::filesystem::path table_path_ = folder_.write("parts/table.glb", table_file().glb());
  Digest table_digest_ = digest_of_file(table_path_, 1 << 20).value();
  LoadedScene merged_{*load_gltf(file_), {}}, table_{*load_gltf(table_path_), {}};
  ExportedEdits edits_;
};

TEST_F(ExportedAssets, AddedFileRoundTrips) {
  edits_.added.push_back(add_table("table", kNone));
  edits_.added.push_back(add_table("table.1", kNone));
  const ExportedGlb made = exported();
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_NE(made.warnings[0].find("variants"), std::string::npos) << made.warnings[0];
  const Scene again = load(made);
  const Scene& scene = merged_.scene;
  ASSERT_EQ(again.nodes.size(), scene.nodes.size());
  for (size_t i = 0; i < again.nodes.size(); ++i) {
    const Node &read = again.nodes[i], &shown = scene.nodes[i];
    const bool is_lamp = i > 2 && shown.path.ends_with("/lamp");
    if (!is_lamp) {
      EXPECT_EQ(read.path, shown.path);
    }
    EXPECT_EQ(read.world_from_node, shown.world_from_node) << shown.path;
    ASSERT_EQ(read.light == kNone, shown.light == kNone) << shown.path;
    if (read.light != kNone) {
      EXPECT_EQ(again.lights.at(read.light), scene.lights.at(shown.light));
    }
    ASSERT_EQ(read.camera == kNone, shown.camera == kNone) << shown.path;
    if (read.camera != kNone) {
      EXPECT_EQ(again.cameras.at(read.camera), scene.cameras.at(shown.camera));
    }
    expect_same_primitives(again, read, scene, shown);
  }
  // Streams find "lamp" by its name in the displayed scene.
  EXPECT_EQ(std::ranges::count(again.nodes, "lamp", &Node::name), 1);
  EXPECT_EQ(std::ranges::count(again.nodes, "table.1/top/lamp (table.1)", &Node::path), 1);
  EXPECT_EQ(again.images.size(), 3u) << "data are written once";
}

TEST_F(ExportedAssets, AdditionEditsStaySeparate) {
  const ExportedNode first = add_table("table", 0), second = add_table("table.1", kNone);
  edits_.added = {first, second};
  const auto node = [&](const std::string& path) {
    return static_cast<uint32_t>(std::ranges::find(merged_.scene.nodes, path, &Node::path) -
                                 merged_.scene.nodes.begin());
  };
  MaterialFactors wood = factors_of(merged_.scene.materials.at(second.asset->first_material + 1));
  wood.base_color = {0.1f, 0.2f, 1 / 3.0f, 1};
  edits_.materials[second.asset->first_material + 1] = wood;
  MaterialFactors none = factors_of(merged_.scene.materials.at(first.asset->first_material));
  none.base_color = {1, 0, 0, 1};
  edits_.materials[first.asset->first_material] = none;  // of "leg", which has no material
  edits_.transforms[node("table.1/top/leg")].parent_from_node = glm::mat4(2);
  edits_.transforms[node("table.1/top/leg")].parent_from_node[3] = {4, 5, 6, 1};
  edits_.lights[node("arm/table/top/lamp")].intensity = 77;
  edits_.hidden = {node("arm/table/top/leg")};
  edits_.removed = {node("table.1/top/view")};
  const Scene again = load(exported());
  const auto read = [&](const std::string& path) {
    const auto found = std::ranges::find(again.nodes, path, &Node::path);
    EXPECT_NE(found, again.nodes.end()) << path;
    return found == again.nodes.end() ? Node() : *found;
  };
  EXPECT_EQ(factors(again, "table.1/top"), wood);
  EXPECT_EQ(factors(again, "arm/table/top"), factors(merged_.scene, "arm/table/top"));
  EXPECT_EQ(read("arm/table/top/leg").mesh, kNone) << "hidden";
  EXPECT_EQ(factors(again, "table.1/top/leg"), factors(merged_.scene, "table.1/top/leg"));
  EXPECT_TRUE(std::ranges::any_of(
      again.materials, [&](const Material& each) { return factors_of(each).base_color == none.base_color; }));
  EXPECT_EQ(read("table.1/top/leg").parent_from_node,
            edits_.transforms[node("table.1/top/leg")].parent_from_node);
  EXPECT_EQ(read("arm/table/top/leg").parent_from_node, table_.scene.nodes[1].parent_from_node);
  EXPECT_EQ(again.lights.at(read("arm/table/top/lamp (table)").light).intensity, 77);
  EXPECT_EQ(again.lights.at(read("table.1/top/lamp (table.1)").light).intensity, 9);
}

// Instances are made by the loader; nodes of streams are not in the file.
TEST_F(ExportedAssets, StreamedChildrenAreReported) {
  ExportedNode table = add_table("table", kNone);
  Scene& scene = merged_.scene;
  const auto of_stream = add_node(scene, "of a stream", 0, glm::mat4(1));
  const auto copy = add_node(scene, "arm.1", kNone, glm::mat4(1));
  const auto below = add_node(scene, "", copy, glm::mat4(1));
  edits_.added = {std::move(table), {copy, kNone, "arm.1", 0}, {below, copy, {}, of_stream}};
  const ExportedGlb made = exported();
  EXPECT_EQ(made.warnings.size(), 2u) << "and variants";
  EXPECT_TRUE(std::ranges::any_of(made.warnings, [](const std::string& warning) {
    return warning.find("left out") != std::string::npos && warning.find("1 ") != std::string::npos;
  })) << made.warnings.back();
}

// Files of an added .gltf lie in its own folder; the exported file names none.
TEST_F(ExportedAssets, BuffersAndImagesAreEmbedded) {
  test::GltfBuilder builder = table_file();
  folder_.write("parts/table.bin", builder.bin);
  folder_.write("parts/wood.png", test::png(2, 2, 0xff00c040));
  builder.root["images"][0] = {{"uri", "wood.png"}};
  table_path_ = folder_.write("parts/table.gltf", builder.gltf("table.bin"));
  table_digest_ = digest_of_file(table_path_, 1 << 20).value();
  edits_.added.push_back(add_table("table", kNone));
  const ExportedGlb made = exported();
  const Scene again = load(made);
  expect_same_primitives(again, again.nodes.at(3), merged_.scene, merged_.scene.nodes.at(3));
  const json root = json::parse(open_container(folder_.write("made.glb", made.bytes), {}).value().json);
  EXPECT_EQ(root["buffers"].size(), 1u);
  for (const json& image : root["images"]) EXPECT_FALSE(image.contains("uri")) << image;
  // An image that cannot be read is not looked for beside the exported file.
  builder.root["images"][0] = {{"uri", "none.png"}};
  folder_.write("parts/table.gltf", builder.gltf("table.bin"));
  edits_.added[0].asset->digest = digest_of_file(table_path_, 1 << 20).value();
  const ExportedGlb without = exported();
  EXPECT_EQ(without.warnings.size(), 2u);
  EXPECT_EQ(load(without).nodes.size(), again.nodes.size());
}

TEST_F(ExportedAssets, ChangedFilesAreSkipped) {
  edits_.added.push_back(add_table("table", kNone));
  edits_.transforms.clear();
  const size_t node_count = load_gltf(file_)->nodes.size();
  const auto expect_left_out = [&](const char* reason) {
    const ExportedGlb made = exported();
    ASSERT_FALSE(made.warnings.empty()) << reason;
    const std::string& warning = made.warnings.back();
    EXPECT_NE(warning.find("\"table\" is left out"), std::string::npos) << warning;
    EXPECT_NE(warning.find(reason), std::string::npos) << warning;
    EXPECT_EQ(load(made).nodes.size(), node_count);
  };
  test::GltfBuilder same_counts = table_file();
  std::swap(same_counts.root["nodes"][1]["name"], same_counts.root["nodes"][2]["name"]);
  folder_.write("parts/table.glb", same_counts.glb());
  expect_left_out("changed");
  test::GltfBuilder more = table_file();
  more.add_node("more");
  folder_.write("parts/table.glb", more.glb());
  expect_left_out("changed");
  folder_.write("parts/table.glb", std::string_view("glTF"));
  expect_left_out("table.glb");
  for (const json& fault : {json{{"textures", {{{"source", 9}}}}}, json{{"skins", {{{"joints", {99}}}}}},
                            json{{"materials", {{{"normalTexture", {{"index", 9}}}}, json::object()}}}}) {
    test::GltfBuilder damaged = table_file();
    damaged.root.update(fault);
    folder_.write("parts/table.glb", damaged.glb());
    expect_left_out("table.glb");
  }
  std::filesystem::remove(table_path_);
  expect_left_out("table.glb");
}

// The file displays all nodes without parents, the exported one only those that were displayed.
TEST_F(ExportedAssets, FileWithoutScenesGetsOne) {
  test::GltfBuilder builder = arm_with_assets();
  builder.root.erase("scenes");
  builder.root.erase("scene");
  file_ = folder_.write("arm.glb", builder.glb());
  ExportedNode lamp{static_cast<uint32_t>(merged_.scene.nodes.size()), kNone, "first"};
  lamp.light = Light();
  (void)add_node(merged_.scene, "first", kNone, glm::mat4(1));
  edits_.added = {lamp, add_table("table", kNone)};
  const Scene again = load(exported());
  ASSERT_EQ(again.nodes.size(), merged_.scene.nodes.size());
  EXPECT_EQ(again.nodes[2].path, "first");
  EXPECT_EQ(again.nodes[4].path, "table/top");
}

}  // namespace
}  // namespace fire3dv::scene
