// Test of MJCF that MuJoCo 2 does not know: frames, replicas, attached models, texture layers and new
// attributes. Expected poses are computed by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>

#include "convert/mjcf/mjcf_reader.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"
#include "tests/unit/renderer/scene/gltf/model_accessors.h"

namespace fire3dv::convert {
namespace {

class MjcfFeatures : public Mjcf {};

const MjcfBody& body(const MjcfScene& scene, std::string_view name) {
  const auto found = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                  [&](const MjcfBody& each) { return each.name == name; });
  if (found != scene.bodies.end()) return *found;
  ADD_FAILURE() << "no body " << name;
  return scene.bodies.front();
}

const MjcfGeom& geom(const MjcfScene& scene, std::string_view name) {
  static const MjcfGeom kNone;
  const auto found = std::find_if(scene.geoms.begin(), scene.geoms.end(),
                                  [&](const MjcfGeom& each) { return each.name == name; });
  if (found != scene.geoms.end()) return *found;
  ADD_FAILURE() << "no geom " << name;
  return kNone;
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b) {
  EXPECT_LT(glm::distance(a, b), 1e-9) << a.x << " " << a.y << " " << a.z;
}

TEST_F(MjcfFeatures, FramesMoveChildren) {
  const MjcfScene made =
      scene(R"(<default><default class="big"><geom size="3"/></default></default><worldbody>
    <frame pos="1 0 0" euler="0 0 90"><geom name="g" size="1" pos="1 0 0"/>
      <frame pos="0 0 1" childclass="big"><body name="b" pos="2 0 0"><joint type="slide" axis="1 0 0"/><geom name="h"/>
        <frame euler="0 0 90"><joint name="j" axis="1 0 0" pos="1 0 0"/><camera name="c" pos="0 1 0"/></frame></body></frame>
      <light name="l" pos="1 0 0" dir="1 0 0"/></frame></worldbody>
    <keyframe><key qpos=".5 1.5707963267948966"/></keyframe>)");
  EXPECT_TRUE(warnings_.empty());
  expect_near(geom(made, "g").pose.position, {1, 1, 0});
  EXPECT_EQ(geom(made, "h").size.x, 3);
  // The slide moves the body by .5 along the world's Y. The hinge then turns it about its Y axis through its
  // point (0 1 0), which leaves that point where it is.
  const MjcfPose& pose = body(made, "b").world_pose;
  expect_near(pose * glm::dvec3(0, 1, 0), {0, 2.5, 1});
  expect_near(pose.rotation * glm::dvec3(0, 1, 0), {-1, 0, 0});
  expect_near(pose.rotation * glm::dvec3(1, 0, 0), {0, 0, -1});
  expect_near(made.cameras[0].world_pose.position, pose * glm::dvec3(-1, 0, 0));
  expect_near(made.lights[0].position, {1, 1, 0});
  expect_near(made.lights[0].direction, {0, 1, 0});
}

TEST_F(MjcfFeatures, ReplicasHaveNumberedNames) {
  const MjcfScene made = scene(R"(<worldbody><replicate count="12" offset="0 0 1" euler="0 0 30">
      <body name="b" pos="1 0 0"><freejoint/><geom name="g" size=".1"/></body></replicate>
    <replicate count="2" offset="1 0 0" sep="-"><replicate count="3" offset="0 1 0"><geom name="n" size=".1"/></replicate></replicate>
    </worldbody>)");
  ASSERT_EQ(made.bodies.size(), 13u);
  EXPECT_EQ(made.bodies[1].name, "b00");
  expect_near(body(made, "b03").world_pose.position, {0, 1, 3});
  expect_near(body(made, "b11").world_pose.rotation * glm::dvec3(1, 0, 0),
              {std::cos(11 * 0.5235987755982988), std::sin(11 * 0.5235987755982988), 0});
  EXPECT_EQ(geom(made, "g07").body, 8u);
  expect_near(geom(made, "n2-1").pose.position, {1, 2, 0});
}

TEST_F(MjcfFeatures, AttachedModelsKeepSettings) {
  folder_.write("t.obj", std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  folder_.write("child.xml", std::string_view(R"(<mujoco model="child"><compiler angle="radian"/>
    <default><geom rgba="1 0 0 1"/><default class="thick"><geom size=".5"/></default></default><asset><mesh file="t.obj"/></asset>
    <worldbody><geom name="floor" type="plane" size="1 1 1"/><body name="root" childclass="thick"><joint/>
      <body name="hand" pos="0 0 1" euler="0 0 1.5707963267948966"><joint axis="1 0 0"/><geom name="palm"/>
        <geom name="nail" type="mesh" mesh="t"/></body></body></worldbody></mujoco>)"));
  const MjcfScene made = scene(R"(<asset><model name="robot" file="child.xml"/></asset><worldbody>
    <frame pos="5 0 0"><attach model="robot" body="hand" prefix="left-"/></frame>
    <body name="base" pos="0 3 0"><attach model="robot" body="root" prefix="right-"/></body>
    <attach model="robot" prefix="all-"/><attach model="nobody" prefix="x"/><attach model="robot" body="foot" prefix="y"/></worldbody>)");
  ASSERT_EQ(warnings_.size(), 2u);
  EXPECT_NE(warnings_[0].find("no model \"nobody\""), std::string::npos) << warnings_[0];
  EXPECT_NE(warnings_[1].find("no body \"foot\""), std::string::npos) << warnings_[1];
  expect_near(body(made, "left-hand").world_pose.position, {5, 0, 1});
  expect_near(body(made, "left-hand").world_pose.rotation * glm::dvec3(1, 0, 0), {0, 1, 0});
  EXPECT_EQ(geom(made, "left-palm").size.x, 0.5) << "the class around the body in its own model";
  EXPECT_EQ(geom(made, "left-palm").rgba[1], 0.0f);
  expect_near(body(made, "right-hand").world_pose.position, {0, 3, 1});
  EXPECT_EQ(geom(made, "all-floor").shape, MjcfShape::plane);
  EXPECT_EQ(made.meshes.size(), 1u) << "assets are shared by all copies";
}

TEST_F(MjcfFeatures, TendonsCopyTheirSites) {
  folder_.write("child.xml",
                std::string_view(R"(<mujoco model="leg"><worldbody><body name="b"><site name="a"/>
    <site name="c" pos="0 0 1"/></body></worldbody><tendon><spatial name="t"><site site="a"/><site site="c"/></spatial></tendon></mujoco>)"));
  const MjcfScene made =
      scene(R"(<asset><model file="child.xml"/></asset><worldbody><site name="s" pos="9 0 0"/>
      <replicate count="2" offset="1 0 0"><frame pos="0 1 0"><attach model="leg" body="b" prefix="p-"/></frame><site name="u"/></replicate></worldbody>
    <tendon><spatial name="x"><site site="s"/><site site="s"/></spatial><spatial name="y"><site site="u"/><site site="u"/></spatial>
      <spatial name="z"><site site="s"/><site site="none"/></spatial></tendon>)");
  ASSERT_EQ(made.tendons.size(), 5u);
  EXPECT_EQ(made.tendons[0].name, "x");
  EXPECT_EQ(made.tendons[1].name, "y0");
  EXPECT_EQ(made.tendons[2].name, "p-t0");
  EXPECT_EQ(made.tendons[4].name, "p-t1");
  ASSERT_EQ(made.tendons[4].pieces.size(), 1u);
  expect_near(made.tendons[4].pieces[0].to, {1, 1, 1});
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("spatial \"z\" is left out"), std::string::npos) << warnings_[0];
}

TEST_F(MjcfFeatures, ModelThatAttachesItselfEnds) {
  const MjcfScene made =
      scene(R"(<worldbody><body name="a"><geom size="1"/><attach body="a" prefix="p"/></body></worldbody>)");
  EXPECT_EQ(made.geoms.size(), 21u);
  EXPECT_NE(warnings_.back().find("nested more than 20 deep"), std::string::npos) << warnings_.back();
}

TEST_F(MjcfFeatures, MaterialLayersAndPhysicalAttributes) {
  folder_.write("t.png", test::png(2, 2, 0x00ff00ff));
  const Result<Model> read = try_read(
      R"(<mujoco><asset><texture name="color" type="2d" file="t.png"/><texture name="bumps" type="2d" file="t.png"/>
      <material name="m" metallic=".7" roughness=".2"><layer role="rgb" texture="color"/><layer role="normal" texture="bumps"/>
        <layer role="occlusion" texture="bumps"/></material></asset>
    <worldbody><geom type="box" size="1 1 1" material="m"/></worldbody></mujoco>)");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->materials.size(), 1u);
  EXPECT_EQ(read->materials[0].metallic, 0.7f);
  EXPECT_EQ(read->materials[0].roughness, 0.2f);
  EXPECT_TRUE(read->materials[0].base_color_image && read->materials[0].normal_image);
  ASSERT_EQ(read->warnings.size(), 1u);
  EXPECT_NE(read->warnings[0].find("role \"occlusion\""), std::string::npos) << read->warnings[0];
}

TEST_F(MjcfFeatures, ModelsWithoutViewsAreFramed) {
  const std::string body =
      "<worldbody><geom type='plane' size='50 50 .1'/><geom type='box' size='1 2 .5' pos='9 0 "
      ".5'/></worldbody>";
  const Result<Model> framed = try_read("<mujoco>" + body + "</mujoco>");
  ASSERT_TRUE(framed.ok());
  const Node& overview = framed->nodes.front();
  EXPECT_EQ(overview.name, "overview");
  EXPECT_EQ(framed->nodes[1].name, "free camera");
  const double half_fov = framed->cameras[*overview.camera].vertical_fov_rad / 2;
  double widest = 0;
  for (const double x : {8., 10.})
    for (const double y : {-2., 2.})
      for (const double z : {0., 1.}) {
        const glm::dvec3 seen =
            glm::conjugate(overview.rotation) * (glm::dvec3(x, y, z) - overview.translation);
        ASSERT_LT(seen.z, 0);
        widest = std::max({widest, 0.75 * std::abs(seen.x / seen.z), std::abs(seen.y / seen.z)});
      }
  EXPECT_LT(widest, 0.91 * std::tan(half_fov)) << "all, with a margin, in an image of 4:3";
  EXPECT_GT(widest, 0.85 * std::tan(half_fov)) << "the image is filled";
  EXPECT_GT(overview.translation.x, 9) << "from the front";
  EXPECT_LT(overview.translation.y, 0);
  for (const std::string view : {"<statistic extent='3'/>", "<visual><global azimuth='10'/></visual>"}) {
    const Result<Model> given = try_read("<mujoco>" + view + body + "</mujoco>");
    ASSERT_TRUE(given.ok());
    EXPECT_EQ(given->nodes.front().name, "free camera");
  }
}

TEST_F(MjcfFeatures, PrimitivesRepeatTexturesAndMeshesShowThem) {
  const std::string text =
      R"(<mujoco><asset><texture name="t" type="2d" builtin="checker" width="8" height="8"/>
      <mesh name="m" vertex="-1 -1 0  1 -1 0  1 1 0  0 0 1"/><material name="r" texture="t" texrepeat="4 2"/>
      <material name="u" texture="t" texrepeat="4 2" texuniform="true"/></asset><worldbody>
      <body name="b"><geom type="box" size=".5 3 1" material="r"/></body><body name="c"><geom type="box" size=".5 3 1" material="u"/></body>
      <body name="d"><geom type="mesh" mesh="m" material="r"/></body></worldbody></mujoco>)";
  const Result<Model> model = try_read(text);
  ASSERT_TRUE(model.ok());
  const auto extent = [&](const std::string& name) {
    glm::vec2 low(1e9f), high(-1e9f);
    for (const Node& node : model->nodes)
      if (node.name == name && node.mesh)
        for (const glm::vec2& uv : model->meshes[*node.mesh].surfaces[0].uvs)
          low = glm::min(low, uv), high = glm::max(high, uv);
    return high - low;
  };
  EXPECT_NEAR(extent("b").x, 4, 1e-5f);
  EXPECT_NEAR(extent("b").y, 2, 1e-5f);
  EXPECT_NEAR(extent("c").x, 4 * 0.5f, 1e-5f);
  EXPECT_NEAR(extent("c").y, 2 * 3, 1e-5f);
  EXPECT_GT(extent("d").x, 2) << "projected, with repeats";
}

TEST_F(MjcfFeatures, CameraIntrinsicsAreRead) {
  const MjcfScene made = scene(R"(<worldbody><camera focal="2 3" sensorsize="4 6" resolution="10 10"/>
      <camera focalpixel="50 50" sensorsize="4 6" resolution="100 100"/><camera fovy="70"/><camera projection="orthographic" fovy="3"/>
      <light type="point"/><light type="directional"/><light type="spot" cutoff="20"/><light type="image" texture="t"/></worldbody>)");
  EXPECT_NEAR(made.cameras[0].vertical_fov_deg, 90, 1e-9);
  EXPECT_NEAR(made.cameras[1].vertical_fov_deg, 90, 1e-9);
  EXPECT_EQ(made.cameras[2].vertical_fov_deg, 70);
  EXPECT_EQ(made.lights[0].type, Light::Type::point);
  EXPECT_EQ(made.lights[1].type, Light::Type::directional);
  EXPECT_EQ(made.lights[2].type, Light::Type::spot);
  EXPECT_FALSE(is_scene_light(made.lights[3]));
  EXPECT_EQ(made.cameras[3].height_m, 3);
  EXPECT_EQ(warnings_.size(), 1u) << "image";
}

// MuJoCo's principal point is to the left and down; pixels may be oblong.
TEST_F(MjcfFeatures, CameraIntrinsicsMayBeOffCentre) {
  const MjcfScene made = scene(R"(<worldbody>
      <camera focalpixel="300 300" principalpixel="40 -30" sensorsize="4 3" resolution="320 240"/>
      <camera focal="3.75 3.75" principal="0.5 -0.375" sensorsize="4 3" resolution="320 240"/>
      <camera focalpixel="150 300" sensorsize="4 3" resolution="320 240"/>
      <camera focal="2 3" sensorsize="4 6"/>
      <camera focal="5 5" sensorsize="4 3" resolution="480 240"/></worldbody>)");
  for (const size_t i : {0u, 1u}) {
    EXPECT_NEAR(made.cameras[i].principal_point.x, -40.0 / 240, 1e-12) << i;
    EXPECT_NEAR(made.cameras[i].principal_point.y, 30.0 / 240, 1e-12) << i;
    EXPECT_EQ(made.cameras[i].pixel_aspect, 1) << i;
  }
  EXPECT_NEAR(made.cameras[2].pixel_aspect, 2, 1e-12);
  EXPECT_NEAR(made.cameras[3].pixel_aspect, 1.5, 1e-12);
  EXPECT_NEAR(made.cameras[4].pixel_aspect, 2.0 / 3, 1e-12) << "pixels of the sensor";
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
}

TEST_F(MjcfFeatures, SimulationElementsAreIgnored) {
  scene(
      R"(<option timestep=".01"/><size njmax="1"/><custom/><extension><plugin plugin="x"/></extension><worldbody><body name="b"><joint name="j"/>
      <geom name="g" size="1"/><site name="s"/><plugin plugin="y"/></body></worldbody>
    <contact><exclude body1="b" body2="world"/></contact><equality><joint joint1="j"/></equality><actuator><motor joint="j"/></actuator>
    <sensor><gyro site="s"/></sensor><tendon><fixed name="f"><joint joint="j" coef="1"/></fixed></tendon>)");
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  scene(
      R"(<something/><deformable><flex name="f"/></deformable><worldbody><geom type="sdf"/><composite type="cable"/><flexcomp name="c" type="gmsh"/></worldbody>)");
  EXPECT_EQ(warnings_.size(), 5u);
}

TEST_F(MjcfFeatures, PrimitivesEncloseBoundsOfMesh) {
  const std::string block = "vertex='0 0 0 4 0 0 4 3 0 0 3 0 0 0 2 4 0 2 4 3 2 0 3 2'";
  const MjcfScene made = scene("<compiler fitaabb='true'/><asset><mesh name='m' " + block +
                               "/></asset><worldbody><geom name='b' type='box' mesh='m' pos='0 0 1'/>"
                               "<geom name='s' mesh='m' fitscale='2'/></worldbody>");
  const MjcfGeom& box = geom(made, "b");
  expect_near(box.pose.position, {2, 1.5, 2});
  const glm::dvec3 half = glm::abs(box.pose.rotation * box.size);
  EXPECT_NEAR(half.x * half.y * half.z, 3, 1e-9);
  EXPECT_NEAR(std::max({half.x, half.y, half.z}), 2, 1e-9);
  EXPECT_NEAR(geom(made, "s").size.x, 4, 1e-9);
}

TEST_F(MjcfFeatures, DistanceFieldsAreMeshes) {
  const MjcfScene made = scene(
      "<asset><mesh name='m' builtin='cone' params='4 0'/><mesh name='p'><plugin "
      "instance='torus'/></mesh></asset>"
      "<worldbody><geom name='a' type='sdf' mesh='m'/><geom name='b' type='sdf' mesh='p'/></worldbody>");
  ASSERT_EQ(made.geoms.size(), 1u);
  EXPECT_EQ(geom(made, "a").shape, MjcfShape::mesh);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("computed by a plugin"), std::string::npos) << warnings_[0];
}

TEST_F(MjcfFeatures, ForeignKeyframesAreReported) {
  const MjcfScene made =
      scene(R"(<worldbody><body name="b"><joint type="slide"/><geom size="1"/></body></worldbody>
    <keyframe><key name="home" qpos="1 2"/></keyframe>)");
  expect_near(body(made, "b").world_pose.position, {0, 0, 0});
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("key \"home\": qpos has not 1 numbers"), std::string::npos) << warnings_[0];
}

TEST_F(MjcfFeatures, IncludesResolveBothFolders) {
  std::filesystem::create_directories(folder_.path() / "parts/meshes");
  folder_.write("parts/meshes/t.obj", std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  folder_.write("parts/arm.xml", std::string_view(R"(<mujocoinclude><asset><mesh file="meshes/t.obj"/></asset>
      <include file="more.xml"/></mujocoinclude>)"));
  folder_.write(
      "parts/more.xml",
      std::string_view(R"(<mujoco><worldbody><geom name="g" type="mesh" mesh="t"/></worldbody></mujoco>)"));
  folder_.write("parts/geom.xml", std::string_view("<x><geom size='1'/></x>"));
  const MjcfScene made = scene(
      R"(<include file="parts/arm.xml"/><worldbody><body name="a"><include file="parts/geom.xml"/></body>
      <body name="b"><include file="parts/geom.xml"/></body></worldbody>)");
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  EXPECT_EQ(made.geoms.size(), 3u) << "a file may be included twice";
}

}  // namespace
}  // namespace fire3dv::convert
