// Test of the GLB writer: the loader reads the written model back, and the file is valid glTF.
#include "convert/glb/write_glb.h"
#include "renderer/scene/model/vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "convert/surfaces.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::convert {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Surface triangle(size_t material = 0) {
  Surface surface;
  surface.positions = {{0, 0, 0}, {2, 0, 0}, {0, 1, -3}};
  surface.indices = {0, 1, 2};
  surface.material = material;
  return surface;
}

Model model_of(const Surface& surface) {
  Model model;
  model.name = "scene";
  model.materials.emplace_back();
  model.meshes = {{"mesh", {surface}}};
  model.nodes.emplace_back();
  model.nodes[0].name = "body";
  model.nodes[0].mesh = 0;
  return model;
}

std::vector<std::byte> written(const Model& model, std::vector<std::string>* warnings = nullptr) {
  auto glb = write_glb(model, warnings);
  EXPECT_TRUE(glb.ok()) << glb.error().message;
  return glb ? std::move(*glb) : std::vector<std::byte>();
}

scene::Scene loaded(const Model& model, std::vector<std::string>* warnings = nullptr) {
  auto scene = scene::load_glb(written(model, warnings), "written");
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  if (!scene) return {};
  EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
  return std::move(*scene);
}

nlohmann::json json_of(const std::vector<std::byte>& glb) {
  uint32_t length = 0;
  std::memcpy(&length, &glb[12], 4);
  const auto* text = reinterpret_cast<const char*>(&glb[20]);
  return nlohmann::json::parse(text, text + length);
}

const scene::Node& node_named(const scene::Scene& scene, std::string_view name) {
  for (const scene::Node& node : scene.nodes)
    if (node.name == name) return node;
  ADD_FAILURE() << "no node " << name;
  return scene.nodes.front();
}

TEST(WriteGlb, NodesStandUnderOneRoot) {
  Model model = model_of(triangle());
  model.nodes[0].translation = {1, 2, 3};
  model.nodes[0].rotation = glm::angleAxis(0.5, glm::dvec3(0, 0, 1));
  Node child;
  child.name = "/ambf/env/BODY tool yaw link";  // blanks and slashes stay
  child.parent = 0;
  child.translation = {0, 0, 4};
  child.scale = {1, 2, 3};
  model.nodes.push_back(child);
  const scene::Scene scene = loaded(model);
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.nodes[0].name, "scene");
  const glm::vec3 body(node_named(scene, "body").world_from_node[3]);
  EXPECT_LT(glm::distance(body, glm::vec3(1, 3, -2)), 1e-6f);  // Z up to Y up
  const scene::Node& tool = node_named(scene, child.name);
  EXPECT_EQ(scene.nodes[tool.parent].name, "body");
  EXPECT_EQ(tool.scale, glm::vec3(1, 2, 3));
  EXPECT_LT(glm::distance(glm::vec3(tool.world_from_node[3]), glm::vec3(1, 7, -2)), 1e-5f);
}

TEST(WriteGlb, RootNameIsUnique) {
  Model model = model_of(triangle());
  model.name = "body";
  const scene::Scene scene = loaded(model);
  EXPECT_EQ(scene.nodes[0].name, "body (scene)");
  EXPECT_EQ(scene.nodes[1].name, "body");
}

TEST(WriteGlb, SharedMeshesKeepVertices) {
  Model model = model_of(triangle());
  Surface with_all = triangle(1);
  with_all.normals.assign(3, {0, 0, 1});
  with_all.uvs = {{0, 0}, {1, 0.25f}, {3, -2}};
  model.materials.emplace_back();
  model.meshes[0].surfaces.push_back(with_all);
  model.nodes.push_back(model.nodes[0]);
  model.nodes[1].name = "twin";
  const scene::Scene scene = loaded(model);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(node_named(scene, "twin").mesh, node_named(scene, "body").mesh);
  ASSERT_EQ(scene.primitives.size(), 2u);
  const scene::Primitive& second = scene.primitives[1];
  EXPECT_EQ(second.bounds_min, glm::vec3(0, 0, -3));
  EXPECT_EQ(second.bounds_max, glm::vec3(2, 1, 0));
  for (uint32_t v = 0; v < 3; ++v) {
    EXPECT_EQ(scene.positions[second.first_vertex + v], with_all.positions[v]);
    EXPECT_EQ(scene.uvs[second.first_vertex + v], with_all.uvs[v]);
  }
}

TEST(WriteGlb, MaterialsAndLightsRoundTrip) {
  Model model = model_of(triangle());
  Material& material = model.materials[0];
  material.name = "glass";
  material.base_color = {0.25f, 0.5f, 0.75f, 0.5f};
  material.metallic = 0.125f;
  material.roughness = 0.625f;
  material.emission = {2, 1, 0};  // above the range of glTF's factor
  material.double_sided = false;
  material.blended = true;
  model.lights.push_back({"sun", Light::Type::directional, {1, 0.5f, 0.25f}, 3});
  model.lights.push_back({"cone", Light::Type::spot, {1, 1, 1}, 7, 0.25f, 0.5f});
  model.cameras.push_back({"eye", 0.75f, 0.125f, 50.0f, 1.5f, 2, {0.25f, -0.125f}, std::nullopt});
  model.cameras.push_back({"drawing", 0.75f, 0.125f, 50.0f, 1.5f, 1, {0, 0}, 3.0f});
  model.nodes[0].light = 1;
  model.nodes.push_back(Node{"camera node"});
  model.nodes.back().camera = 0;
  const scene::Scene scene = loaded(model);
  const scene::Material& back = scene.materials[scene.primitives[0].material];
  EXPECT_EQ(back.base_color, material.base_color);
  EXPECT_EQ(back.metallic, 0.125f);
  EXPECT_EQ(back.roughness, 0.625f);
  EXPECT_EQ(back.emissive, material.emission);
  EXPECT_FALSE(back.double_sided);
  EXPECT_EQ(back.alpha_mode, scene::AlphaMode::blend);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].type, scene::LightType::directional);
  EXPECT_EQ(scene.lights[0].color, glm::vec3(1, 0.5f, 0.25f));
  EXPECT_EQ(scene.lights[1].intensity, 7);
  EXPECT_EQ(scene.lights[1].outer_cone_rad, 0.5f);
  EXPECT_EQ(node_named(scene, "body").light, 1u);
  const scene::Camera& camera = scene.cameras[node_named(scene, "camera node").camera];
  EXPECT_EQ(camera.vertical_fov_rad, 0.75f);
  EXPECT_EQ(camera.near_m, 0.125f);
  EXPECT_EQ(camera.far_m, 50);
  EXPECT_EQ(camera.aspect, 1.5f);
  EXPECT_EQ(camera.pixel_aspect, 2);
  EXPECT_EQ(camera.principal_point, glm::vec2(0.25f, -0.125f));
  EXPECT_TRUE(scene.cameras[1].orthographic);
  EXPECT_EQ(scene.cameras[1].half_extent_m, glm::vec2(2.25f, 1.5f));
  EXPECT_EQ(scene.cameras[1].far_m, 50);
}

// 2 x 2 pixels, 24 bits, bottom row first: blue, green / red, white.
std::vector<std::byte> bmp() {
  std::vector<uint8_t> bytes(70);
  const auto set = [&](size_t at, std::initializer_list<uint8_t> values) {
    std::copy(values.begin(), values.end(), bytes.begin() + static_cast<ptrdiff_t>(at));
  };
  set(0, {'B', 'M', 70});
  set(10, {54, 0, 0, 0, 40});                   // offset of the pixels, size of the header
  set(18, {2, 0, 0, 0, 2, 0, 0, 0, 1, 0, 24});  // width, height, planes, bits
  set(54, {255, 0, 0, 0, 255, 0});
  set(62, {0, 0, 255, 255, 255, 255});
  const auto* first = reinterpret_cast<const std::byte*>(bytes.data());
  return {first, first + bytes.size()};
}

TEST(WriteGlb, OtherImagesBecomePng) {
  Model model = model_of(triangle());
  model.meshes[0].surfaces[0].uvs.assign(3, {0.5f, 0.5f});
  model.images.push_back({"colour.png", test::png(3, 1, 0x102030ff)});
  model.images.push_back({"colour.bmp", bmp()});
  std::vector<std::byte> cut = test::png(64, 64, 0x405060ff);
  cut.resize(cut.size() - 20);
  model.images.push_back({"cut.png", cut});
  model.images.push_back({"text.png", std::vector<std::byte>(100, std::byte{'x'})});
  for (size_t i = 0; i < model.images.size(); ++i) {
    Material material;
    material.base_color_image = i;
    model.materials.push_back(material);
    model.meshes[0].surfaces.push_back(model.meshes[0].surfaces[0]);
    model.meshes[0].surfaces.back().material = i + 1;
  }
  std::vector<std::string> warnings;
  const scene::Scene scene = loaded(model, &warnings);
  ASSERT_EQ(scene.images.size(), 2u);
  EXPECT_EQ(scene.images[0].width, 3u);
  EXPECT_EQ(scene.images[1].name, "colour.bmp");
  const std::vector<uint8_t> pixels = {0, 0, 255, 255, 0, 255, 0, 255};
  EXPECT_EQ(std::vector<uint8_t>(scene.images[1].rgba8.begin() + 8, scene.images[1].rgba8.end()), pixels);
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("\"cut.png\" is left out: the PNG file is cut short"), std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[1].find("\"text.png\""), std::string::npos) << warnings[1];
}

TEST(WriteGlb, UndecodableImageIsSkipped) {
  std::vector<std::byte> garbage = test::png(64, 64, 0x405060ff);
  const std::string_view data = "IDAT";
  const auto* name = reinterpret_cast<const std::byte*>(data.data());
  const auto at = std::search(garbage.begin(), garbage.end(), name, name + data.size());
  ASSERT_GT(garbage.end() - at, 20);
  std::fill(at + 4, at + 14, std::byte{0xff});
  uint64_t pixels_left = kMaxPixelsInAll;
  const auto broken = glb_image({"garbage.png", garbage}, pixels_left);
  ASSERT_FALSE(broken.ok());
  EXPECT_NE(broken.error().message.find("cannot be decoded"), std::string::npos) << broken.error().message;
  EXPECT_EQ(pixels_left, kMaxPixelsInAll);

  const Image sound{"sound.png", test::png(3, 2, 0xff)};
  pixels_left = 7;
  EXPECT_TRUE(glb_image(sound, pixels_left).ok());
  EXPECT_EQ(pixels_left, 1u);
  const auto too_many = glb_image(sound, pixels_left);
  ASSERT_FALSE(too_many.ok());
  EXPECT_NE(too_many.error().message.find("too many pixels"), std::string::npos) << too_many.error().message;
}

TEST(WriteGlb, CompletePngIsCopied) {
  std::vector<uint8_t> pixels(size_t{300} * 200 * 4);
  uint32_t random = 1;
  for (uint8_t& value : pixels) value = static_cast<uint8_t>((random = random * 1664525 + 1013904223) >> 24);
  for (const uint32_t channels : {3u, 4u}) {
    const auto png = png_of(std::span(pixels).first(size_t{300} * 200 * channels), 300, 200, channels);
    ASSERT_TRUE(png.ok());
    uint64_t pixels_left = kMaxPixelsInAll;
    const Image image{"a.png", *png};
    const auto copied = glb_image(image, pixels_left);
    ASSERT_TRUE(copied.ok()) << copied.error().message;
    EXPECT_EQ(copied->bytes.data(), image.bytes.data());
    EXPECT_EQ(copied->mime_type, "image/png");
    EXPECT_EQ(kMaxPixelsInAll - pixels_left, 300u * 200);
    // One row more than there are pixels: the height is the second number of the header.
    Image tall = image;
    tall.bytes[23] = std::byte{201};
    EXPECT_FALSE(glb_image(tall, pixels_left).ok());
    // Damaged anywhere: what is accepted can be decoded.
    for (size_t i = 0; i < 200; ++i) {
      Image damaged = image;
      damaged.bytes[8 + (i * 7919) % (damaged.bytes.size() - 8)] ^= std::byte{0x55};
      Model model = model_of(triangle());
      model.meshes[0].surfaces[0].uvs.assign(3, {0.5f, 0.5f});
      model.images.push_back(damaged);
      model.materials[0].base_color_image = 0;
      std::vector<std::string> warnings;
      EXPECT_EQ(loaded(model, &warnings).images.size() + warnings.size(), 1u) << i;
    }
  }
}

TEST(WriteGlb, ForbiddenValuesAreRepaired) {
  Surface surface;
  surface.positions = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {kNan, 0, 0}, {0, HUGE_VALF, 0}};
  surface.normals = {{0, 0, 5}, {0, 0, 0}, {kNan, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  surface.indices = {0, 1, 2, 0, 1, 3, 0, 4, 1, 0, 1, 77, 0, 1};
  Model model = model_of(surface);
  model.nodes[0].name = "caf\xe9 \xc3\xa9\n";  // Latin-1, UTF-8, and a newline
  std::vector<std::string> warnings;
  const std::vector<std::byte> glb = written(model, &warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("4 triangles with positions that are not finite are left out"),
            std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[0].find("2 normals"), std::string::npos) << warnings[0];
  const auto scene = scene::load_glb(glb, "written");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_EQ(scene->nodes[1].name, "caf? \xc3\xa9?");
  EXPECT_EQ(scene->indices.size(), 3u);
  EXPECT_EQ(scene->bounds_max.x, 2);
  for (uint32_t v = 0; v < 3; ++v) EXPECT_EQ(scene::normal_of(scene->frames[v]), glm::vec3(0, 0, 1));
}

TEST(WriteGlb, FileIsValidGltf) {
  Model model = model_of(triangle());
  model.materials.emplace_back();  // unused
  model.images.push_back({"unused", test::png(1, 1, 0xff)});
  model.meshes.push_back({"nothing to see", {}});
  model.nodes.push_back(Node{"empty"});
  model.nodes.back().mesh = 1;
  const std::vector<std::byte> glb = written(model);
  EXPECT_EQ(glb, written(model));
  uint32_t length = 0;
  std::memcpy(&length, &glb[8], 4);
  EXPECT_EQ(length, glb.size());
  EXPECT_EQ(glb.size() % 4, 0u);
  const nlohmann::json json = json_of(glb);
  EXPECT_EQ(json["asset"]["version"], "2.0");
  EXPECT_EQ(json["materials"].size(), 1u);
  EXPECT_EQ(json["meshes"].size(), 1u);
  EXPECT_FALSE(json.contains("images"));
  for (const auto& view : json["bufferViews"]) {
    EXPECT_EQ(view.value("byteOffset", 0) % 4, 0);
    EXPECT_LE(view.value("byteOffset", 0) + view["byteLength"].get<int>(), json["buffers"][0]["byteLength"]);
  }
  const auto& positions =
      json["accessors"][json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
  EXPECT_EQ(positions["min"], (std::vector<double>{0, 0, -3}));
  EXPECT_EQ(positions["max"], (std::vector<double>{2, 1, 0}));
}

TEST(WriteGlb, NanPoseIsRefusedByNode) {
  Model model = model_of(triangle());
  model.nodes[0].translation.y = kNan;
  const auto glb = write_glb(model);
  ASSERT_FALSE(glb.ok());
  EXPECT_NE(glb.error().message.find("\"body\""), std::string::npos);
}

double volume(const Surface& surface) {
  double six_times = 0;
  for (size_t i = 0; i < surface.indices.size(); i += 3) {
    const glm::dvec3 a(surface.positions[surface.indices[i]]), b(surface.positions[surface.indices[i + 1]]),
        c(surface.positions[surface.indices[i + 2]]);
    six_times += glm::dot(a, glm::cross(b, c));
  }
  return six_times / 6;
}

// Volume test: closed and outward if the volume is right; polygons have slightly less than circles.
TEST(Shapes, ShapesHaveExactVolume) {
  constexpr double pi = 3.14159265358979;
  EXPECT_NEAR(volume(box({1, 2, 3})), 48, 1e-4);
  EXPECT_NEAR(volume(ellipsoid({1, 2, 3})) / (4 * pi / 3 * 6), 0.99, 0.01);
  EXPECT_NEAR(volume(cylinder(0.5, 2)) / (pi * 0.25 * 4), 0.995, 0.005);
  EXPECT_NEAR(volume(capsule(0.5, 2)) / (pi * 0.25 * 4 + 4 * pi / 3 * 0.125), 0.99, 0.01);
}

TEST(Shapes, MirroredShapesFaceOutwards) {
  Mesh mesh;
  add_surface(mesh, box({1, 1, 1}), glm::dmat4(glm::dmat3(-2, 0, 0, 0, 1, 0, 0, 0, 1)), 0);
  add_surface(mesh, box({1, 1, 1}), matrix_of({10, 0, 0}, {1, 0, 0, 0}), 0);
  ASSERT_EQ(mesh.surfaces.size(), 1u);  // one material
  EXPECT_NEAR(volume(mesh.surfaces[0]), 16 + 8, 1e-4);
  const Surface& surface = mesh.surfaces[0];
  for (size_t i = 0; i < surface.indices.size(); i += 3) {
    const uint32_t* v = &surface.indices[i];
    const glm::vec3 face = glm::cross(surface.positions[v[1]] - surface.positions[v[0]],
                                      surface.positions[v[2]] - surface.positions[v[0]]);
    EXPECT_GT(glm::dot(face, surface.normals[v[0]]), 0);
  }
}

}  // namespace
}  // namespace fire3dv::convert
