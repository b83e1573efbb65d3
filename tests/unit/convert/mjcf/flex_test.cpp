// Test of MJCF flexes: bodies, surfaces and influences of flexcomp and flex elements, with computed values,
// and malformed data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

#include "convert/mjcf/deformable/flex_shape.h"
#include "convert/surfaces.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"

namespace fire3dv::convert {
namespace {

double flex_volume(const Surface& surface) {
  double sum = 0;
  for (size_t i = 0; i + 3 <= surface.indices.size(); i += 3) {
    const glm::dvec3 a(surface.positions[surface.indices[i]]), b(surface.positions[surface.indices[i + 1]]),
        c(surface.positions[surface.indices[i + 2]]);
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

TEST(MjcfFlexShape, SurfacesHaveExactVolume) {
  const struct {
    const char* type;
    int dimension;
    std::array<int, 3> count;
    double volume, tolerance;
    size_t points;
  } shapes[] = {{"box", 3, {4, 3, 5}, 0.3 * 0.2 * 0.4, 1e-6, 1 + 60 - 2 * 1 * 3},
                {"box", 2, {4, 3, 5}, 0.3 * 0.2 * 0.4, 1e-6, 60 - 2 * 1 * 3},
                {"grid", 3, {4, 3, 5}, 0.3 * 0.2 * 0.4, 1e-6, 60},
                {"cylinder", 3, {21, 21, 3}, std::numbers::pi * 0.2, 0.02, 1 + 3 * 441 - 19 * 19},
                {"ellipsoid", 2, {21, 21, 21}, 4 * std::numbers::pi / 3, 0.06, 9261 - 19 * 19 * 19}};
  for (const auto& each : shapes) {
    const Result<FlexShape> shape = flex_grid({each.type, each.count, glm::dvec3(0.1)}, each.dimension);
    ASSERT_TRUE(shape.ok()) << each.type << ": " << shape.error().message;
    EXPECT_EQ(shape->points.size(), each.points) << each.type;
    EXPECT_EQ(shape->uvs.size(), each.points) << each.type;
    EXPECT_NEAR(flex_volume(flex_surface(*shape, 0.01, false).surface), each.volume, each.tolerance)
        << each.type;
  }
}

TEST(MjcfFlexShape, LinesAreCapsules) {
  const Result<FlexShape> circle = flex_grid({"circle", {7, 1, 1}, glm::dvec3(0.5)}, 1);
  ASSERT_TRUE(circle.ok()) << circle.error().message;
  ASSERT_EQ(circle->points.size(), 6u);
  for (size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(glm::distance(circle->points[i], circle->points[(i + 1) % 6]), 0.5, 1e-12);
  const FlexSurface tube = flex_surface(*flex_grid({"grid", {3, 1, 1}, glm::dvec3(0.5)}, 1), 0.1, false);
  double length = 0;
  for (size_t v = 0; v < tube.points.size(); ++v) {
    length = std::max(length, std::abs(static_cast<double>(tube.surface.positions[v].x)));
    EXPECT_LE(std::hypot(tube.surface.positions[v].y, tube.surface.positions[v].z), 0.1 + 1e-6);
    EXPECT_LE(std::abs(tube.surface.positions[v].x - 0.5f * (static_cast<float>(tube.points[v]) - 1)), 0.35f);
  }
  EXPECT_NEAR(length, 0.6, 1e-6);
}

TEST(MjcfFlexShape, InvalidCountsAreErrors) {
  for (const char* type : {"grid", "box", "disc", "circle", "ball"})
    for (const int count : {-1, 0, 1, 1'000'000})
      for (int dimension = 1; dimension <= 3; ++dimension)
        EXPECT_FALSE(flex_grid({type, {count, count, count}, glm::dvec3(0.1)}, dimension).ok())
            << type << count;
  EXPECT_FALSE(flex_grid({"grid", {9, 9, 9}, glm::dvec3(0)}, 3).ok());
  EXPECT_FALSE(flex_grid({"grid", {100, 100, 100}, glm::dvec3(1)}, 3).ok());
  EXPECT_TRUE(flex_grid({"box", {100, 100, 100}, glm::dvec3(1)}, 3).ok()) << "points inside do not count";
}

class MjcfFlex : public Mjcf {
 protected:
  Model read(const std::string& text) {
    Result<Model> model = try_read("<mujoco>" + text + "</mujoco>");
    EXPECT_TRUE(model.ok()) << (model ? "" : model.error().message);
    return model ? std::move(*model) : Model();
  }
  static const Node* node(const Model& model, std::string_view name) {
    const auto found = std::find_if(model.nodes.begin(), model.nodes.end(),
                                    [&](const Node& each) { return each.name == name; });
    return found == model.nodes.end() ? nullptr : &*found;
  }
  // Vertices of the skinned mesh of a node in the world.
  static std::vector<glm::dvec3> vertices(const Model& model, std::string_view name) {
    const Node* const skinned = node(model, name);
    if (!skinned || !skinned->skin || !skinned->mesh) return {};
    std::vector<glm::dmat4> world;
    for (const Node& each : model.nodes)
      world.push_back((each.parent ? world[*each.parent] : glm::dmat4(1)) *
                      matrix_of(each.translation, each.rotation));
    std::vector<glm::dvec3> made;
    const Surface& surface = model.meshes[*skinned->mesh].surfaces[0];
    for (size_t v = 0; v < surface.positions.size(); ++v) {
      glm::dvec4 sum(0);
      for (size_t i = 0; i < 8; ++i) {
        const Skin::Joint& joint = model.skins[*skinned->skin].joints[surface.influences[v].joints[i]];
        sum += static_cast<double>(surface.influences[v].weights[i]) * (world[joint.node] * joint.from_mesh) *
               glm::dvec4(glm::dvec3(surface.positions[v]), 1);
      }
      made.emplace_back(sum);
    }
    return made;
  }
  static bool contains(const std::vector<glm::dvec3>& points, const glm::dvec3& wanted) {
    return std::any_of(points.begin(), points.end(),
                       [&](const glm::dvec3& point) { return glm::distance(point, wanted) < 1e-6; });
  }
};

TEST_F(MjcfFlex, UnpinnedGridPointsAreBodies) {
  // Points: (-1 -1), (-1 1), (1 -1), (1 1), turned by 90 degrees; the last three move in the keyframe.
  const Model model = read(
      "<worldbody><body name='p' pos='0 0 5'><flexcomp name='f' type='grid' dim='2' count='2 2 1' spacing='2 "
      "2 2' "
      "pos='0 0 1' euler='0 0 90' rgba='1 0 0 1'><pin id='0'/></flexcomp></body></worldbody>"
      "<keyframe><key qpos='0 0 0 0 0 .5 0 0 0'/></keyframe>");
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
  EXPECT_FALSE(node(model, "f_0")) << "pinned";
  ASSERT_TRUE(node(model, "f_1") && node(model, "f_2") && node(model, "f_3"));
  EXPECT_LT(glm::distance(node(model, "f_1")->translation, glm::dvec3(-1, -1, 1)), 1e-12);
  EXPECT_LT(glm::distance(node(model, "f_2")->translation, glm::dvec3(1, 1, 1.5)), 1e-12) << "keyframe";
  const std::vector<glm::dvec3> all = vertices(model, "f");
  ASSERT_EQ(all.size(), 4u);
  for (const glm::dvec3& point : {glm::dvec3(1, -1, 6), {-1, -1, 6}, {1, 1, 6.5}, {-1, 1, 6}})
    EXPECT_TRUE(contains(all, point)) << point.x << " " << point.y << " " << point.z;
}

TEST_F(MjcfFlex, LatticesBlendTheirNodes) {
  // The node at the upper corner moves up by 1: the centre of the cube moves by an eighth.
  std::string qpos;
  for (int i = 0; i < 24; ++i) qpos += i == 23 ? "1 " : "0 ";
  const Model model = read(
      "<worldbody><body name='p'><flexcomp name='f' type='direct' dim='3' dof='trilinear' "
      "point='0 0 0 2 0 0 0 2 0 0 0 2 2 2 2 1 1 1' element='0 1 2 5 0 1 3 5 4 1 2 5'/></body></worldbody>"
      "<keyframe><key qpos='" +
      qpos + "'/></keyframe>");
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
  ASSERT_TRUE(node(model, "f_1_1_1"));
  const std::vector<glm::dvec3> all = vertices(model, "f");
  EXPECT_TRUE(contains(all, {1, 1, 1.125}));
  EXPECT_TRUE(contains(all, {2, 2, 3}));
  EXPECT_TRUE(contains(all, {0, 0, 0}));
}

TEST_F(MjcfFlex, ElementlessPointsAreSkipped) {
  const Model model = read(
      "<worldbody><body name='p'><flexcomp name='f' type='direct' dim='2' scale='2 2 2' "
      "point='9 9 9 0 0 0 1 0 0 8 8 8 0 1 0' element='1 2 4'/>"
      "<flexcomp name='r' type='direct' dim='2' rigid='true' point='0 0 3 1 0 3 0 1 3' element='0 1 "
      "2'/></body></worldbody>");
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
  EXPECT_TRUE(node(model, "f_2"));
  EXPECT_FALSE(node(model, "f_3") || node(model, "r_0"));
  EXPECT_TRUE(contains(vertices(model, "f"), {0, 2, 0}));
  EXPECT_TRUE(contains(vertices(model, "r"), {0, 1, 3}));
}

TEST_F(MjcfFlex, MeshesShareEqualVertices) {
  folder_.write("t.obj",
                std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n"));
  const Model model = read(
      "<worldbody><body name='p'><flexcomp name='f' type='mesh' dim='2' file='t.obj'/>"
      "<flexcomp name='g' type='gmsh' dim='3' file='t.msh'/></body></worldbody>");
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("GMSH files are not supported"), std::string::npos) << model.warnings[0];
  EXPECT_TRUE(node(model, "f_3"));
  EXPECT_FALSE(node(model, "f_4"));
  EXPECT_EQ(vertices(model, "f").size(), 4u);
}

TEST_F(MjcfFlex, VerticesAreInBodyFrames) {
  const Model model = read(
      "<worldbody><body name='a' pos='0 0 1' euler='0 0 90'/><body name='b' pos='5 0 "
      "0'/></worldbody><deformable>"
      "<flex name='f' dim='2' body='a b a' vertex='1 0 0 0 0 2 0 0 0' element='0 1 2'/>"
      "<flex name='one' dim='2' body='b' vertex='1 0 0 0 1 0 0 0 0' element='0 1 2'/>"
      "<flex name='centred' dim='1' body='a b' element='0 1'/></deformable>");
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
  const std::vector<glm::dvec3> all = vertices(model, "f");
  for (const glm::dvec3& point : {glm::dvec3(0, 1, 1), {5, 0, 2}, {0, 0, 1}})
    EXPECT_TRUE(contains(all, point));
  EXPECT_TRUE(contains(vertices(model, "one"), {5, 1, 0}));
  EXPECT_FALSE(vertices(model, "centred").empty());
}

TEST_F(MjcfFlex, MalformedAreSkippedWithReason) {
  const struct {
    const char *attributes, *part;
  } faults[] = {
      {"dim='4'", "dim is not from 1 to 3"},
      {"count='2 2 0'", "none"},
      {"count='0 2 1'", "count is too small"},
      {"count='9999999 9999999 9999999' dim='3'", "count is too large"},
      {"type='ball'", "type=\"ball\" is not supported"},
      {"type='circle'", "a circle needs dim=1"},
      {"type='mesh'", "neither a file nor vertices"},
      {"type='mesh' file='none.obj'", "does not exist"},
      {"type='direct' point='0 0 0' element='0 1 2'", "names point 1 of 1"},
      {"type='direct' point='0 0' element='0 1 2'", "not three numbers"},
      {"type='direct' point='0 0 1e300' element='0 0 0'", "beyond 2^30"},
      {"type='direct' point='0 0 0' element='-1 0 0'", "negative or huge"},
      {"type='direct' point='0 0 0'", "not 3 numbers"},
      {"dof='trilinear' type='direct' point='0 0 0' element='0 0 0' cellcount='0 1 1'", "cellcount"}};
  for (const auto& fault : faults) {
    const Model model = read("<worldbody><body name='p'><geom size='1'/><flexcomp name='f' " +
                             std::string(fault.attributes) + "/></body></worldbody>");
    const std::string said = model.warnings.empty() ? "none" : model.warnings[0];
    EXPECT_NE(said.find(fault.part), std::string::npos) << fault.attributes << ": " << said;
  }
  const Model model = read(
      "<worldbody><body name='a'><geom size='1'/><flexcomp name='p' count='3 3 1'><pin id='-1 99' range='0 "
      "1e12' "
      "grid='7 7' gridrange='-5 -5 99 99'/></flexcomp></body></worldbody><deformable>"
      "<flex name='n' body='nobody' element='0 0 0'/><flex name='o' body='a a' vertex='0 0 0' element='0 0 "
      "0'/>"
      "<flex name='e' body='a' vertex='0 0 0' element='0 0 7'/><flex name='z' node='a' element='0 0 "
      "0'/></deformable>");
  ASSERT_EQ(model.warnings.size(), 5u);
  const char* const parts[] = {"a pin names a point", "no body \"nobody\"", "2 bodies for 1 vertices",
                               "names vertex 7 of 1", "nodes of a lattice"};
  for (size_t i = 0; i < 5; ++i)
    EXPECT_NE(model.warnings[i].find(parts[i]), std::string::npos) << model.warnings[i];
}

}  // namespace
}  // namespace fire3dv::convert
