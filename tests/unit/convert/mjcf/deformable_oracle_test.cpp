// Test of MJCF skins and composites against libmujoco: the skinned vertices of the written model are those
// that libmujoco draws in the first keyframe; bodies and geoms of composites are those that it generates.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/mujoco/compiled/compiled_scene.h"
#include "adapters/mujoco/compiled/load.h"
#include "convert/mjcf/mjcf_reader.h"
#include "convert/readers.h"
#include "convert/surfaces.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mjcf/mjcf_oracle.h"

namespace fire3dv::convert {
namespace {

class MjcfDeformableOracle : public testing::Test {
 protected:
  // Returns the vertices of all skins that libmujoco draws, in the world.
  static std::vector<glm::dvec3> drawn_by_mujoco(const mjModel& model, mjData& data) {
    mjvScene scene;
    mjv_defaultScene(&scene);
    mjv_makeScene(&model, &scene, 10'000);
    std::vector<std::string> warnings;  // the function is deprecated, and this version has no other
    EXPECT_TRUE(call_mujoco([&] { mjv_updateSkin(&model, &data, &scene); }, &warnings).ok());
    std::vector<glm::dvec3> vertices;
    for (int i = 0; i < model.nskinvert; ++i) {
      const float* v = scene.skinvert + 3 * i;
      vertices.emplace_back(glm::vec3(v[0], v[1], v[2]));
    }
    mjv_freeScene(&scene);
    return vertices;
  }

  // Skins as glTF defines them.
  static std::vector<glm::dvec3> drawn_by_us(const Model& model) {
    std::vector<glm::dmat4> world;
    for (const Node& node : model.nodes)
      world.push_back((node.parent ? world[*node.parent] : glm::dmat4(1)) *
                      matrix_of(node.translation, node.rotation));
    std::vector<glm::dvec3> vertices;
    for (const Node& node : model.nodes) {
      if (!node.skin) continue;
      const Surface& surface = model.meshes[*node.mesh].surfaces[0];
      for (size_t v = 0; v < surface.positions.size(); ++v) {
        glm::dvec4 sum(0);
        for (size_t i = 0; i < 8; ++i) {
          const Skin::Joint& joint = model.skins[*node.skin].joints[surface.influences[v].joints[i]];
          sum += static_cast<double>(surface.influences[v].weights[i]) *
                 (world[joint.node] * joint.from_mesh) * glm::dvec4(glm::dvec3(surface.positions[v]), 1);
        }
        vertices.emplace_back(sum);
      }
    }
    return vertices;
  }

  void compare(const std::string& text, size_t expected_vertices) {
    const auto file = folder_.write("model.xml", std::string_view("<mujoco>" + text + "</mujoco>"));
    const Result<MjcfModel> compiled = compile_mjcf(file, nullptr);
    ASSERT_TRUE(compiled.ok()) << compiled.error().message;
    const Result<MjcfData> posed = pose_mjcf(**compiled, nullptr);
    ASSERT_TRUE(posed.ok()) << posed.error().message;
    const std::vector<glm::dvec3> theirs = drawn_by_mujoco(**compiled, **posed);
    ASSERT_EQ(theirs.size(), expected_vertices);
    const Result<Model> model = read_mjcf(file, {});
    ASSERT_TRUE(model.ok()) << model.error().message;
    for (const std::string& warning : model->warnings) ADD_FAILURE() << warning;
    const std::vector<glm::dvec3> ours = drawn_by_us(*model);
    ASSERT_EQ(ours.size(), theirs.size());
    for (size_t i = 0; i < ours.size(); ++i)
      EXPECT_LT(glm::distance(ours[i], theirs[i]), 1e-6)
          << i << ": " << theirs[i].x << " " << theirs[i].y << " " << theirs[i].z;
  }

  // Bodies and geoms of a composite, and its skin. Tendons between its bodies are not drawn.
  void compare_composite(const std::string& text, size_t expected_vertices = 0) {
    compare(text, expected_vertices);
    const auto file = folder_.path() / "model.xml";
    const Result<MjcfModel> compiled = compile_mjcf(file, nullptr);
    const Result<MjcfData> posed = pose_mjcf(**compiled, nullptr);
    Sources sources;
    std::vector<std::string> warnings;
    const Result<MjcfScene> read = read_mjcf_scene(file, {}, sources, warnings);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_GT(read->bodies.size(), 4u);
    for (const std::string& difference : MjcfOracle(*read, compiled_scene(**compiled, **posed)).differences())
      if (!difference.starts_with("tendons")) ADD_FAILURE() << difference;
  }

  test::ScratchFolder folder_;
};

constexpr const char* kBodies =
    R"(<worldbody><body name="a" pos=".1 .2 .3" euler="10 20 30"><freejoint/><geom size=".1"/>
    <body name="b" pos="0 0 .4"><joint axis="1 0 0"/><geom size=".1"/></body></body></worldbody>
  <keyframe><key qpos=".3 .2 .1 .5 .5 -.5 .5 .9"/></keyframe>)";

TEST_F(MjcfDeformableOracle, SkinsWithBlendedBones) {
  compare(std::string(R"(<asset><skin name="s" vertex="0 0 0  .1 0 .2  0 .1 .4  -.1 0 .6" face="0 1 2 0 2 3">
      <bone body="a" bindpos="0 0 .1" bindquat="2 0 0 1" vertid="0 1 2" vertweight="1 3 .5"/>
      <bone body="b" bindpos=".1 0 .5" bindquat="1 .2 .3 0" vertid="1 2 3" vertweight="1 .5 2"/></skin></asset>)") +
              kBodies,
          4);
}

TEST_F(MjcfDeformableOracle, InflatedSkinsMatchMuJoCo) {
  compare(
      std::string(
          R"(<asset><skin name="s" inflate=".03" vertex="0 0 0  .1 0 .2  0 .1 .4  -.1 0 .6" face="0 1 2 0 2 3">
      <bone body="a" bindpos="0 0 .1" bindquat="2 0 0 1" vertid="0 1" vertweight="1 3"/>
      <bone body="b" bindpos=".1 0 .5" bindquat="1 .2 .3 0" vertid="2 3" vertweight=".5 2"/></skin></asset>)") +
          kBodies,
      4);
}

TEST_F(MjcfDeformableOracle, Particles) {
  compare_composite(
      R"(<worldbody><body name="p" pos="0 0 1" euler="0 0 30"><geom size=".01"/><composite type="particle" count="2 3 2" spacing=".2"
      offset=".1 .2 .3"><geom size=".05" rgba="1 0 0 1"/></composite></body></worldbody>
    <keyframe><key qpos="0 .1 .2 0 0 0 0 0 0 .3 0 0  0 0 0 0 0 0 0 0 0 0 0 0  0 0 0 0 0 0 0 0 0 0 0 .5"/></keyframe>)");
}

TEST_F(MjcfDeformableOracle, GridsWithASkin) {
  compare_composite(
      R"(<worldbody><body name="p" pos="0 0 1"><geom size=".01"/><composite prefix="C" type="grid" count="4 3 1" spacing=".2" offset="0 0 .5">
      <skin inflate=".02" texcoord="true" rgba="0 1 0 1"/><pin coord="0 0"/><pin coord="3 0"/><geom size=".05"/></composite></body></worldbody>
    <keyframe><key qpos=".1 .1 .1 0 0 0 0 0 0 0 0 .3 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 -.1"/></keyframe>)",
      24);
  compare_composite(
      R"(<worldbody><body name="p"><composite type="grid" count="5 1 1" spacing=".2"><geom size=".05" group="1"/></composite></body></worldbody>)");
}

TEST_F(MjcfDeformableOracle, RopesAndLoops) {
  for (const char* type : {"rope", "loop"})
    for (const char* body : {"B0", "B3", "B6"})
      compare_composite("<worldbody><body name='" + std::string(body) +
                        "' pos='1 0 1'><freejoint/><composite type='" + type +
                        "' count='7 1 1' spacing='.2'><joint kind='main' damping='1'/><joint kind='stretch'/>"
                        "<geom type='capsule' size='.03 .06'/></composite></body></worldbody>");
}

TEST_F(MjcfDeformableOracle, ClothMatchesMuJoCo) {
  const std::string start =
                        "<worldbody><body name='XB2_1' pos='1 0 1' euler='20 0 0'><freejoint/><composite "
                        "prefix='X' type='cloth' "
                        "count='5 4 1' spacing='.2'>",
                    end = "</composite></body></worldbody>";
  compare_composite(start + "<geom type='capsule' size='.03 .06'/>" + end);
  compare_composite(start + "<skin inflate='.01'/><geom type='ellipsoid' size='.03 .06 .02'/>" + end, 40);
}

TEST_F(MjcfDeformableOracle, Shells) {
  for (const char* type : {"box", "cylinder", "ellipsoid"})
    for (const char* geom : {"sphere", "capsule"})
      compare_composite("<worldbody><body name='p' pos='1 0 1'><freejoint/><composite type='" +
                        std::string(type) + "' count='4 3 5' spacing='.2'><geom type='" + geom +
                        "' size='.03 .06'/></composite></body></worldbody>");
}

}  // namespace
}  // namespace fire3dv::convert
