// Test of the meshes that MuJoCo generates: they are closed, face outwards, and have the volume and bounds of
// their formula. Limits of their parameters.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "convert/mjcf/assets/builtin_mesh.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"

namespace fire3dv::convert {
namespace {

constexpr double kPi = std::numbers::pi;

double volume(const MeshData& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces)
    sum += glm::dot(glm::dvec3(mesh.vertices[a]),
                    glm::cross(glm::dvec3(mesh.vertices[b]), glm::dvec3(mesh.vertices[c]))) /
           6;
  return sum;
}

// Each edge belongs to two triangles that pass it in opposite directions.
bool is_closed(const MeshData& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const MeshData::Triangle& face : mesh.faces)
    for (size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto other = edges.find({edge.first.second, edge.first.first});
    return edge.second == 1 && other != edges.end() && other->second == 1;
  });
}

MeshData made(const std::string& kind, const std::vector<double>& parameters) {
  Result<MeshData> mesh = builtin_mesh(kind, parameters);
  EXPECT_TRUE(mesh.ok()) << kind << ": " << (mesh ? "" : mesh.error().message);
  return mesh ? std::move(*mesh) : MeshData();
}

TEST(MjcfBuiltinMesh, ClosedShapesHaveExactVolume) {
  const struct {
    const char* kind;
    std::vector<double> parameters;
    double volume, tolerance;
  } shapes[] = {
      // An icosahedron with the circumscribed radius 1.
      {"sphere", {0}, 2.536150710130446, 1e-6},
      {"sphere", {4}, 4 * kPi / 3, 0.01},
      {"hemisphere", {0}, 2.0 / 3, 1e-6},
      {"hemisphere", {10}, 2 * kPi / 3, 0.03},
      {"cone", {4, 0}, 4.0 / 3, 1e-6},  // base of area 2, height 2
      {"cone", {4, 1}, 4, 1e-6},        // prism
      {"cone", {4, 0.5}, 7.0 / 3, 1e-6},
      {"supersphere", {100, 1, 1}, 4 * kPi / 3, 0.01},
      {"supersphere", {80, 2, 2}, 4.0 / 3, 1e-6},  // octahedron
      {"supertorus", {100, 0.5, 1, 1}, kPi * kPi / 2, 0.02},
  };
  for (const auto& shape : shapes) {
    const MeshData mesh = made(shape.kind, shape.parameters);
    EXPECT_TRUE(is_closed(mesh)) << shape.kind;
    EXPECT_NEAR(volume(mesh), shape.volume, shape.tolerance) << shape.kind << " " << shape.parameters[0];
    EXPECT_TRUE(check_mesh_data(mesh).ok()) << shape.kind;
  }
}

TEST(MjcfBuiltinMesh, CountsMatchMuJoCo) {
  EXPECT_EQ(made("sphere", {3}).faces.size(), 20u * 64);
  EXPECT_EQ(made("hemisphere", {5}).vertices.size(), 1u + 2 * 6 * 7 + 1);
  EXPECT_EQ(made("hemisphere", {5}).faces.size(), 4u * 6 * 6 + 4 * 6);
  EXPECT_EQ(made("supersphere", {30, .2, .3}).vertices.size(), 30u * 29 + 2);
  EXPECT_EQ(made("supersphere", {30, .2, .3}).faces.size(), 2u * 30 * 29);
  EXPECT_EQ(made("supertorus", {30, .5, .4, 1}).faces.size(), 2u * 30 * 30);
  EXPECT_EQ(made("plate", {4, 3}).faces.size(), 2u * 3 * 2);
}

TEST(MjcfBuiltinMesh, PlatesHaveCellCentres) {
  const MeshData plate = made("plate", {4, 2});
  EXPECT_EQ(plate.vertices.front(), glm::vec3(-0.75, -0.5, -1));
  EXPECT_EQ(plate.vertices.back(), glm::vec3(0.75, 0.5, -1));
  for (const auto& [a, b, c] : plate.faces)
    EXPECT_GT(glm::cross(plate.vertices[b] - plate.vertices[a], plate.vertices[c] - plate.vertices[a]).z, 0);
  const MeshData wedge = made("wedge", {2, 1, 90, 45, 0});
  ASSERT_EQ(wedge.vertices.size(), 2u);
  EXPECT_LT(glm::distance(glm::dvec3(wedge.vertices[1]), glm::dvec3(std::sqrt(.5), 0, -std::sqrt(.5))), 1e-6);
  EXPECT_TRUE(wedge.faces.empty()) << "its convex hull is drawn";
}

TEST(MjcfBuiltinMesh, InvalidParametersAreErrors) {
  const struct {
    const char* kind;
    std::vector<double> parameters;
    const char* part;
  } faults[] = {{"ball", {1}, "\"ball\" is unknown"},
                {"sphere", {}, "needs 1 numbers in params, instead of 0"},
                {"sphere", {5}, "number 1 of params is not from 0 to 4"},
                {"hemisphere", {-1}, "not from 0 to 10"},
                {"cone", {1e9, 0}, "not from 3 to 2000"},
                {"supersphere", {1e9, 1, 1}, "number 1"},
                {"supertorus", {30, 2, 1, 1}, "number 2 of params is not from 0 to 1"},
                {"wedge", {30, 30, 90, std::nan(""), 0}, "number 4"},
                {"plate", {1e6, 1e6}, "number 1"}};
  for (const auto& fault : faults) {
    const Result<MeshData> mesh = builtin_mesh(fault.kind, fault.parameters);
    ASSERT_FALSE(mesh.ok()) << fault.kind;
    EXPECT_NE(mesh.error().message.find(fault.part), std::string::npos) << mesh.error().message;
  }
}

class MjcfBuiltin : public Mjcf {};

TEST_F(MjcfBuiltin, MeshesAreScaled) {
  const Result<Model> model = try_read(
      "<mujoco><asset><mesh name='c' builtin='cone' params='4 1' scale='1 2 3'/>"
      "<mesh name='w' builtin='wedge' params='9 9 60 30 .5'/><mesh name='bad' builtin='cone' "
      "params='x'/></asset>"
      "<worldbody><geom type='mesh' mesh='c'/><geom type='mesh' mesh='w'/><geom type='mesh' "
      "mesh='bad'/></worldbody>"
      "</mujoco>");
  ASSERT_TRUE(model.ok()) << model.error().message;
  ASSERT_EQ(model->warnings.size(), 1u);
  EXPECT_NE(model->warnings[0].find("params holds something else"), std::string::npos) << model->warnings[0];
  glm::vec3 high(0);
  for (const glm::vec3& position : model->meshes[0].surfaces[0].positions) high = glm::max(high, position);
  EXPECT_LT(glm::distance(high, glm::vec3(1, 2, 3)), 1e-5f);
}

}  // namespace
}  // namespace fire3dv::convert
