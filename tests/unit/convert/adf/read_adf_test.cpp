// Test of the ADF reader on the small scene of tests/assets/adf: names, poses, appearance and warnings,
// against numbers computed here.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/constants.hpp>

#include "convert/model.h"
#include "convert/readers.h"

namespace fire3dv::convert {
namespace {

const std::filesystem::path kScene =
    std::filesystem::path(FIRE3DV_SOURCE_DIR) / "tests/assets/adf/launch.yaml";

Model read(std::vector<size_t> indices, const std::string& name_space = {}) {
  ReadOptions options;
  options.launch_indices = std::move(indices);
  options.name_space = name_space;
  Result<Model> model = read_adf(kScene, options);
  EXPECT_TRUE(model) << model.error().message;
  return model ? std::move(*model) : Model{};
}

const Model& scene() {
  static const Model model = read({0, 1, 2});
  return model;
}

size_t index_of(const Model& model, std::string_view name) {
  for (size_t i = 0; i < model.nodes.size(); ++i)
    if (model.nodes[i].name == name) return i;
  ADD_FAILURE() << "no node is called " << name;
  return 0;
}
const Node& node(std::string_view name) {
  return scene().nodes[index_of(scene(), name)];
}

const Material& material_of(const Node& n) {
  return scene().materials[scene().meshes[n.mesh.value()].surfaces.front().material];
}

// ADF's orientation, expanded: Rz(y) Ry(p) Rx(r).
glm::dmat3 rotation(double r, double p, double y) {
  const double cr = std::cos(r), sr = std::sin(r), cp = std::cos(p), sp = std::sin(p), cy = std::cos(y),
               sy = std::sin(y);
  const double rows[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                             {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                             {-sp, cp * sr, cp * cr}};
  glm::dmat3 m;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) m[column][row] = rows[row][column];
  return m;
}

glm::dmat4 world_from(const Model& model, size_t index) {
  const Node& n = model.nodes[index];
  glm::dmat4 parent_from = glm::mat4_cast(n.rotation);
  parent_from[3] = glm::dvec4(n.translation, 1);
  return n.parent ? world_from(model, *n.parent) * parent_from : parent_from;
}

void expect_pose(const std::string& name, const glm::dvec3& at, const glm::dmat3& turned) {
  const glm::dmat4 world_from_node = world_from(scene(), index_of(scene(), name));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(world_from_node[3][c], at[c], 1e-12) << name;
    for (int r = 0; r < 3; ++r)
      EXPECT_NEAR(world_from_node[c][r], turned[c][r], 1e-12) << name << ' ' << c << r;
  }
}

void expect_color(const glm::vec4& linear, const glm::vec3& displayed, float opacity) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(linear[i], linear_from_srgb(displayed)[i], 1e-6);
  EXPECT_FLOAT_EQ(linear.a, opacity);
}

TEST(AdfScene, NodesKeepAmbfOrder) {
  std::vector<std::string> names;
  for (const Node& n : scene().nodes)
    if (n.name.find('#') == std::string::npos) names.push_back(n.name);
  const std::vector<std::string> expected{
      "/ambf/env/BODY floor", "/ambf/env/BODY lost", "/ambf/env/lights/lamp",
      // This body has children that the world file lists before it.
      "/ambf/env/parts/BODY eye", "/ambf/env/lights/head lamp", "/ambf/env/cameras/stereo eye",
      "/ambf/env/cameras/side", "/ambf/env/shapes/BODY box", "/ambf/env/shapes/BODY sphere",
      "/ambf/env/shapes/BODY cylinder", "/ambf/env/shapes/BODY cone", "/ambf/env/shapes/BODY capsule",
      "/ambf/env/shapes/BODY compound", "/ambf/env/shapes/BODY hidden", "/ambf/env/shapes/BODY not hidden",
      "/ambf/env/parts/BODY hex nut", "/ambf/env/parts/BODY painted nut", "/elsewhere/BODY pyramid",
      "/ambf/env/parts/BODY hex nut1", "/ambf/env/parts/BODY lost part", "/ambf/env/ghosts/GHOST marker",
      "/ambf/env/ghosts/GHOST orphan"};
  EXPECT_EQ(names, expected);
  for (size_t i = 0; i < scene().nodes.size(); ++i)
    EXPECT_LT(scene().nodes[i].parent.value_or(0), std::max<size_t>(i, 1));
}

TEST(AdfScene, LaunchIndicesAreAmbfs) {
  EXPECT_EQ(read({}).nodes.size(), read({1}).nodes.size());  // the launch file's own choice
  ReadOptions all;
  all.launch_all = true;
  const Result<Model> model = read_adf(kScene, all);
  ASSERT_TRUE(model);
  // A model listed twice has two instances.
  EXPECT_NE(world_from(*model, index_of(*model, "/ambf/env/shapes/BODY box1"))[3][0], 0);
  const Model prefixed = read({2}, "/second");
  index_of(prefixed, "/second/ambf/env/ghosts/GHOST marker");
  ReadOptions wrong;
  wrong.launch_indices = {4};
  const Result<Model> none = read_adf(kScene, wrong);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("has no model 4: it lists 4, counted from 0"), std::string::npos)
      << none.error().message;
}

TEST(AdfScene, PosesAreThoseOfFormula) {
  expect_pose("/ambf/env/shapes/BODY box", {-0.5, -0.3, 0}, rotation(0.3, -0.4, 0.9));
  expect_pose("/ambf/env/BODY lost", {1, 2, 3}, rotation(0.1, 0.2, 0.3));
  expect_pose("/ambf/env/parts/BODY hex nut1", {-0.4, 0.15, 0}, rotation(0.4, 0.3, -0.5));
  // The pose of a ghost is relative to its parent.
  expect_pose("/ambf/env/ghosts/GHOST marker", {0.05, 0.15, 0.1}, rotation(0, 0, 0.5));
  expect_pose("/ambf/env/ghosts/GHOST orphan", {0, 0, 0.4}, glm::dmat3(1));
  expect_pose("/ambf/env/parts/BODY eye", {0, -0.9, 1.2}, rotation(0.6435011087932844, 0, 0));
}

TEST(AdfScene, CamerasLookWhereAmbfsDo) {
  // The eye is rotated about X by an angle with sine 0.6 and cosine 0.8; its camera looks along its -Z.
  const glm::dvec3 down(0, 0.6, -0.8), up(0, 0.8, 0.6), right(1, 0, 0);
  const glm::dvec3 at = glm::dvec3(0, -0.9, 1.2) - 0.05 * down;
  expect_pose("/ambf/env/cameras/stereo eye", at, glm::dmat3(-down, right, up));       // AMBF's frame
  expect_pose("/ambf/env/cameras/stereo eye#view", at, glm::dmat3(right, up, -down));  // glTF's frame
  expect_pose("/ambf/env/cameras/stereo eye#left", at - 0.01 * right, glm::dmat3(right, up, -down));
  expect_pose("/ambf/env/cameras/stereo eye#right", at + 0.01 * right, glm::dmat3(right, up, -down));
  const Camera& camera = scene().cameras[node("/ambf/env/cameras/stereo eye#left").camera.value()];
  EXPECT_EQ(camera.name, "/ambf/env/cameras/stereo eye#left");
  EXPECT_FLOAT_EQ(camera.vertical_fov_rad, 0.8f);
  EXPECT_FLOAT_EQ(camera.near_m, 0.01f);
  EXPECT_FLOAT_EQ(camera.far_m.value(), 8);
  EXPECT_EQ(scene().cameras[node("/ambf/env/cameras/side#view").camera.value()].name,
            "/ambf/env/cameras/side");
  EXPECT_FALSE(node("/ambf/env/cameras/side").camera);
}

TEST(AdfScene, LightsShineWhereAmbfsDo) {
  const glm::dvec3 along = glm::normalize(glm::dvec3(-0.4, 0.55, -1));
  const glm::dmat4 lamp = world_from(scene(), index_of(scene(), "/ambf/env/lights/lamp"));
  const glm::dmat4 shine = world_from(scene(), index_of(scene(), "/ambf/env/lights/lamp#light"));
  EXPECT_NEAR(glm::distance(glm::dvec3(lamp[0]), along), 0, 1e-12);
  EXPECT_NEAR(glm::distance(glm::dvec3(-shine[2]), along), 0, 1e-12);
  EXPECT_NEAR(glm::distance(glm::dvec3(shine[3]), glm::dvec3(0.6, -0.8, 1.6)), 0, 1e-12);
  const Light& light = scene().lights[node("/ambf/env/lights/lamp#light").light.value()];
  EXPECT_NEAR(light.outer_cone_rad, 0.7 * 180 / 3.14 * glm::pi<double>() / 180, 1e-6);
  EXPECT_LT(light.inner_cone_rad, light.outer_cone_rad);
  const Light& head = scene().lights[node("/ambf/env/lights/head lamp#light").light.value()];
  EXPECT_NEAR(head.outer_cone_rad, glm::half_pi<double>(), 1e-6);  // the maximum angle of a spot light
  EXPECT_GT(light.intensity, 0);
  EXPECT_GT(head.intensity, 0);
}

TEST(AdfScene, ColoursFollowAmbfsPrecedence) {
  expect_color(material_of(node("/ambf/env/shapes/BODY box")).base_color, {0.8f, 0.1f, 0.1f}, 0.6f);
  EXPECT_TRUE(material_of(node("/ambf/env/shapes/BODY box")).blended);
  EXPECT_FLOAT_EQ(material_of(node("/ambf/env/shapes/BODY box")).roughness, std::sqrt(2.0f / 32));
  expect_color(material_of(node("/ambf/env/shapes/BODY sphere")).base_color, {0.2f, 0.7f, 0.3f}, 1);
  const Material glowing = material_of(node("/ambf/env/shapes/BODY cylinder"));
  expect_color(glm::vec4(glowing.emission, 1), {0.1f, 0.2f, 0.9f}, 1);
  const Material solid = material_of(node("/ambf/env/shapes/BODY cone"));
  expect_color(solid.base_color, {0.9f, 0.8f, 0.1f}, 1);
  EXPECT_FALSE(solid.blended);
  expect_color(material_of(node("/ambf/env/shapes/BODY compound")).base_color, glm::vec3(0.7f), 1);
  expect_color(material_of(node("/ambf/env/ghosts/GHOST marker")).base_color, {0.8f, 0.04f, 0.02f}, 0.4357f);
  EXPECT_FALSE(node("/ambf/env/shapes/BODY hidden").mesh);
  ASSERT_TRUE(node("/ambf/env/shapes/BODY not hidden").mesh);

  // The file's own materials, or the body's colour times the file's image.
  const Mesh& own = scene().meshes[node("/ambf/env/parts/BODY hex nut").mesh.value()];
  ASSERT_EQ(own.surfaces.size(), 2u);
  for (const Surface& s : own.surfaces) {
    const Material& m = scene().materials[s.material];
    if (m.base_color_image)
      expect_color(m.base_color, glm::vec3(0.9f), 1);
    else
      expect_color(m.base_color, {0.15f, 0.3f, 0.2f}, 1);
  }
  EXPECT_EQ(node("/ambf/env/parts/BODY hex nut1").mesh, node("/ambf/env/parts/BODY hex nut").mesh);
  const Mesh& painted = scene().meshes[node("/ambf/env/parts/BODY painted nut").mesh.value()];
  size_t with_image = 0;
  for (const Surface& s : painted.surfaces) {
    expect_color(scene().materials[s.material].base_color, {0.9f, 0.6f, 0.2f}, 1);
    with_image += scene().materials[s.material].base_color_image.has_value();
  }
  EXPECT_EQ(with_image, 1u);
}

glm::vec3 extent(const std::string& name) {
  glm::vec3 low(1e9f), high(-1e9f);
  for (const Surface& s : scene().meshes[node(name).mesh.value()].surfaces)
    for (const glm::vec3& p : s.positions) low = glm::min(low, p), high = glm::max(high, p);
  EXPECT_LT(glm::length(low + high), 1e-6f + 0.25f * glm::length(high - low)) << name << " is not centred";
  return high - low;
}

// Signed volume by the divergence theorem: positive for a closed mesh with outward winding.
double volume(const std::string& name) {
  double sum = 0;
  for (const Surface& s : scene().meshes[node(name).mesh.value()].surfaces)
    for (size_t i = 0; i < s.indices.size(); i += 3) {
      const glm::dvec3 a(s.positions[s.indices[i]]), b(s.positions[s.indices[i + 1]]),
          c(s.positions[s.indices[i + 2]]);
      sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
  return sum;
}

TEST(AdfScene, ShapesHaveAmbfsSizes) {
  const auto expect_extent = [](const std::string& name, const glm::vec3& expected) {
    EXPECT_LT(glm::distance(extent(name), expected), 1e-5f) << name;
  };
  expect_extent("/ambf/env/shapes/BODY box", {0.2f, 0.1f, 0.15f});
  expect_extent("/ambf/env/shapes/BODY sphere", glm::vec3(0.16f));
  expect_extent("/ambf/env/shapes/BODY cylinder", {0.2f, 0.2f, 0.2f});  // scaled by 2; always along Z
  expect_extent("/ambf/env/shapes/BODY cone", {0.2f, 0.2f, 0.2f});
  expect_extent("/ambf/env/shapes/BODY capsule", {0.1f, 0.1f, 0.24f});   // semi-axes, as AMBF draws it
  expect_extent("/ambf/env/shapes/BODY compound", {0.3f, 0.3f, 0.05f});  // both parts at the origin
  expect_extent("/ambf/env/BODY floor", {100, 100, 0});
  expect_extent("/ambf/env/parts/BODY painted nut", {0.3f, 0.15f * std::sqrt(3.0f), 0.12f});
  EXPECT_NEAR(volume("/ambf/env/shapes/BODY box"), 0.2 * 0.1 * 0.15, 1e-9);
  const double ball = glm::pi<double>() * 4 / 3;
  EXPECT_NEAR(volume("/ambf/env/shapes/BODY sphere") / (ball * 0.08 * 0.08 * 0.08), 1, 0.02);
  EXPECT_NEAR(volume("/ambf/env/shapes/BODY capsule") / (ball * 0.05 * 0.05 * 0.12), 1, 0.02);
  EXPECT_NEAR(volume("/ambf/env/shapes/BODY cylinder") / (glm::pi<double>() * 0.01 * 0.2), 1, 0.01);
  EXPECT_NEAR(volume("/ambf/env/shapes/BODY cone") / (glm::pi<double>() * 0.01 * 0.2 / 3), 1, 0.01);
  // Polygons become fans, and line elements of the file are dropped.
  EXPECT_NEAR(volume("/ambf/env/parts/BODY hex nut"), 1.5 * std::sqrt(3.0) * 0.01 * 0.08, 1e-7);
  size_t triangles = 0;
  for (const Surface& s : scene().meshes[node("/ambf/env/parts/BODY hex nut").mesh.value()].surfaces)
    triangles += s.indices.size() / 3;
  EXPECT_EQ(triangles, 4u + 12u + 4u);
}

TEST(AdfScene, MissingFilesReportOnce) {
  const auto count = [](const std::string& part) {
    return std::count_if(scene().warnings.begin(), scene().warnings.end(),
                         [&](const std::string& w) { return w.find(part) != std::string::npos; });
  };
  EXPECT_EQ(scene().warnings.size(), 5u);
  EXPECT_EQ(count("floor.yaml:19: \"mesh\" of \"BODY lost\" is left out"), 1);
  EXPECT_EQ(count("parts.yaml:63: \"mesh\" of \"BODY lost part\" is left out"), 1);
  EXPECT_EQ(
      count("parts.yaml:7: \"bodies\" lists \"BODY nowhere described\", which the file does not describe"),
      1);
  EXPECT_EQ(count("\"/ambf/env/ghosts/GHOST orphan\" has the parent \"BODY of nobody\", which is not there"),
            1);
  EXPECT_EQ(count("\"colour\" (" + (kScene.parent_path() / "models/parts.yaml:14").string() + ")"), 1);
  EXPECT_EQ(count("\"colour components\""), 1);
  EXPECT_TRUE(node("/ambf/env/parts/BODY lost part").mesh == std::nullopt);
  // Every file that was read or searched.
  for (const char* file :
       {"launch.yaml", "world/world.yaml", "world/floor.yaml", "models/high_res/hex nut.OBJ",
        "models/high_res/hex nut.mtl", "models/high_res/checker board.png",
        "models/high_res/../more/pyramid.STL", "models/high_res/no such part.STL"}) {
    EXPECT_TRUE(scene().sources.contains(kScene.parent_path() / file)) << file;
  }
}

}  // namespace
}  // namespace fire3dv::convert
