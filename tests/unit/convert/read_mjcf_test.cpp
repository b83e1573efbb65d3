// Test of the MJCF reader (libmujoco): bodies as nodes in the first keyframe's pose, visible geoms, cameras
// and lights.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "tests/unit/convert/mjcf_fixture.h"
#include "tests/unit/scene/model_accessors.h"

namespace fire3dv::convert {
namespace {

#ifdef FIRE3DV_HAS_MUJOCO

Model checked(Result<Model> model) {
  EXPECT_TRUE(model.ok()) << model.error().message;
  return model ? std::move(*model) : Model();
}

constexpr const char* kArm = R"(<mujoco model="arm">
  <worldbody>
    <light name="sun" directional="true" dir="0 0 -1" diffuse="1 1 1"/>
    <light name="lamp" pos="0 0 3" dir="0 1 0" cutoff="30"/>
    <geom type="plane" size="0 0 1"/>
    <body name="shoulder" pos="0 0 1">
      <joint name="turn" axis="0 0 1"/>
      <geom type="box" size="0.1 0.2 0.3" pos="0 0 0.3"/>
      <body pos="1 0 0">
        <joint axis="0 0 1"/>
        <geom type="capsule" size="0.1 0.4"/>
        <geom type="sphere" size="0.5" group="3"/>
        <geom type="sphere" size="0.5" rgba="1 0 0 0"/>
        <camera name="shoulder" pos="0 0 1" fovy="60"/>
      </body>
    </body>
  </worldbody>
  <keyframe><key qpos="1.5707963267948966 0"/></keyframe>
</mujoco>)";

TEST_F(Mjcf, BodiesAreNodesInTheFirstKeyframesPose) {
  const Model model = checked(try_read(kArm));
  EXPECT_EQ(node(model, "world").parent, std::nullopt);
  const Node& shoulder = node(model, "shoulder");
  EXPECT_EQ(model.nodes[*shoulder.parent].name, "world");
  EXPECT_LT(glm::distance(shoulder.translation, glm::dvec3(0, 0, 1)), 1e-12);
  EXPECT_LT(glm::distance(shoulder.rotation * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), 1e-9);
  const Node& unnamed = node(model, "body_2");
  EXPECT_EQ(model.nodes[*unnamed.parent].name, "shoulder");
  EXPECT_LT(glm::distance(unnamed.translation, glm::dvec3(1, 0, 0)), 1e-9);  // relative to its parent
}

TEST_F(Mjcf, GeomsOfTheGroupsThatAreShownHaveTheirSizes) {
  const Model model = checked(try_read(kArm));
  const auto [box_low, box_high] = bounds(model.meshes[*node(model, "shoulder").mesh]);
  EXPECT_LT(glm::distance(box_low, glm::vec3(-0.1f, -0.2f, 0)), 1e-6f);
  EXPECT_LT(glm::distance(box_high, glm::vec3(0.1f, 0.2f, 0.6f)), 1e-6f);
  const auto [low, high] = bounds(model.meshes[*node(model, "body_2").mesh]);  // neither group 3 nor alpha 0
  EXPECT_LT(glm::distance(low, glm::vec3(-0.1f, -0.1f, -0.5f)), 1e-6f);
  EXPECT_LT(glm::distance(high, glm::vec3(0.1f, 0.1f, 0.5f)), 1e-6f);
  EXPECT_GT(bounds(model.meshes[*node(model, "world").mesh]).second.x, 5);  // an infinite plane
}

TEST_F(Mjcf, CamerasAndLightsBelongToTheirBodies) {
  const Model model = checked(try_read(kArm));
  EXPECT_EQ(model.nodes.front().name, "free camera");
  const Node& eye = node(model, "shoulder camera");  // a body already has the name
  EXPECT_EQ(model.nodes[*eye.parent].name, "body_2");
  EXPECT_EQ(model.cameras[*eye.camera].name, "shoulder");
  EXPECT_NEAR(model.cameras[*eye.camera].vertical_fov_rad, 1.0471976f, 1e-6f);
  EXPECT_LT(glm::distance(eye.translation, glm::dvec3(0, 0, 1)), 1e-9);
  const Node& sun = node(model, "sun");
  EXPECT_EQ(model.lights[*sun.light].type, Light::Type::directional);
  EXPECT_LT(glm::distance(sun.rotation * glm::dvec3(0, 0, -1), glm::dvec3(0, 0, -1)), 1e-9);
  const Node& lamp = node(model, "lamp");
  EXPECT_EQ(model.lights[*lamp.light].type, Light::Type::spot);
  EXPECT_NEAR(model.lights[*lamp.light].outer_cone_rad, 0.5235988f, 1e-6f);
  EXPECT_LT(glm::distance(lamp.rotation * glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0)), 1e-9);
}

TEST_F(Mjcf, MaterialsMeshesAndTexturesComeFromTheCompiledModel) {
  std::filesystem::create_directories(folder_.path() / "assets");
  folder_.write("assets/t.obj",
                std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"));
  folder_.write("assets/skin.png", test::png(2, 2, 0x00ff00ff));
  folder_.write(
      "parts.xml",
      std::string_view(R"(<mujoco><asset><mesh name="t" file="t.obj" scale="2 2 2"/></asset></mujoco>)"));
  const Model model = checked(try_read(R"(<mujoco><compiler meshdir="assets" texturedir="assets"/>
    <include file="parts.xml"/>
    <asset><texture name="skin" type="2d" file="skin.png"/><texture name="sky" type="cube" builtin="flat" rgb1="1 0 0" width="4" height="4"/>
      <material name="red" rgba="1 0 0 0.5" shininess="1" reflectance="0.25" emission="0.5"/>
      <material name="skinned" texture="skin" texuniform="true" texrepeat="3 2"/><material name="cubed" texture="sky"/></asset>
    <worldbody><geom type="plane" size="2 4 1" material="skinned"/>
      <body name="a"><geom type="mesh" mesh="t" material="red"/></body><body name="b"><geom type="mesh" mesh="t" material="red"/></body>
      <body name="c"><geom size="1" material="cubed" rgba="0 0 1 1"/></body></worldbody></mujoco>)"));
  EXPECT_EQ(node(model, "a").mesh, node(model, "b").mesh);
  const Mesh& mesh = model.meshes[*node(model, "a").mesh];
  const auto [low, high] = bounds(mesh);
  EXPECT_LT(glm::distance(low, glm::vec3(0)), 1e-5f);  // in its own frame, independent of its inertia
  EXPECT_LT(glm::distance(high, glm::vec3(2)), 1e-5f);
  const Material& red = model.materials[mesh.surfaces[0].material];
  EXPECT_EQ(red.base_color, glm::vec4(1, 0, 0, 0.5f));
  EXPECT_TRUE(red.blended);
  EXPECT_EQ(red.metallic, 0.25f);
  EXPECT_NEAR(red.roughness, std::pow(2 / 130.0f, 0.25f), 1e-6f);
  EXPECT_NEAR(red.emission.r, 0.21404f, 1e-4f);
  const Surface& ground = model.meshes[*node(model, "world").mesh].surfaces[0];
  EXPECT_EQ(model.materials[ground.material].base_color_image, 0u);
  EXPECT_EQ(ground.uvs[1] - ground.uvs[0], glm::vec2(6, 0));  // 3 repetitions per unit of the half size
  const Material& cubed = model.materials[model.meshes[*node(model, "c").mesh].surfaces[0].material];
  EXPECT_EQ(cubed.base_color, glm::vec4(0, 0, 1, 1));
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("\"sky\" is a cube"), std::string::npos);
  for (const char* file : {"model.xml", "parts.xml", "assets/t.obj", "assets/skin.png"})
    EXPECT_TRUE(model.sources.contains(folder_.path() / file)) << file;
}

TEST_F(Mjcf, AHeightFieldIsItsTopAndItsWalls) {
  const Model model =
      checked(try_read(R"(<mujoco><asset><hfield name="h" nrow="2" ncol="3" size="3 2 1 0.5"/></asset>
    <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>)"));
  const auto [low, high] = bounds(model.meshes[0]);
  EXPECT_EQ(low, glm::vec3(-3, -2, -0.5f));
  EXPECT_EQ(glm::vec2(high), glm::vec2(3, 2));
  EXPECT_EQ(model.meshes[0].surfaces[0].indices.size() / 3, 4u + 2 * 6u);
}

TEST_F(Mjcf, TrianglesAreBoundedAndThatIsSaid) {
  std::string bodies;
  for (int i = 0; i < 30; ++i)
    bodies += "<body><geom type='box' size='1 1 " + std::to_string(1 + i / 2) + "'/></body>";
  ReadOptions options;
  options.most_triangles = 100;
  const Model model = checked(try_read("<mujoco><worldbody>" + bodies + "</worldbody></mujoco>", options));
  EXPECT_EQ(model.meshes.size(), 9u) << "12 triangles each, for two bodies each";
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("those after it lack geoms: the scene has more than 100 triangles"),
            std::string::npos)
      << model.warnings[0];
}

TEST_F(Mjcf, ErrorsNameTheFile) {
  const auto error_of = [&](const std::string& text) {
    const auto model = try_read(text);
    EXPECT_FALSE(model.ok()) << text;
    return model ? "" : model.error().message;
  };
  const std::string unknown = error_of("<mujoco>\n<worldbody>\n<blob/>\n</worldbody></mujoco>");
  EXPECT_NE(unknown.find("model.xml\": "), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("line 3"), std::string::npos) << unknown;
  const std::string missing =
      error_of("<mujoco><asset><mesh name='m' file='gone.stl'/></asset><worldbody/></mujoco>");
  EXPECT_NE(missing.find("gone.stl"), std::string::npos) << missing;
  const std::string broken = error_of("<mujoco>\n<worldbody>\n");
  EXPECT_NE(broken.find("model.xml"), std::string::npos) << broken;
  folder_.write("loop.xml", std::string_view("<mujoco><include file='loop.xml'/></mujoco>"));
  EXPECT_NE(error_of("<mujoco><include file='loop.xml'/><worldbody/></mujoco>").find("loop.xml"),
            std::string::npos);
}

// Security: an untrusted model names files outside of its folder, in several disguises; none of them is read.
TEST_F(Mjcf, FilesOutsideTheModelsFolderNeedAnOption) {
  namespace fs = std::filesystem;
  const fs::path model = folder_.path() / "model", ours = folder_.path() / "ours";
  fs::create_directories(model / "assets");
  fs::create_directories(ours);
  constexpr std::string_view kTetrahedron =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const auto write = [&](const char* name, const std::string& text) {
    return folder_.write(name, std::string_view(text));
  };
  write("ours/t.obj", std::string(kTetrahedron));
  write("ours/key.mtl", "newmtl secret\n");
  folder_.write("ours/skin.png", test::png(2, 2, 0x00ff00ff));
  write("ours/parts.xml", "<mujoco><option/></mujoco>");
  fs::create_symlink(ours, model / "link");
  fs::create_symlink(ours / "t.obj", model / "link.obj");
  const std::string library = "mtllib own.mtl ";
  const auto mesh = [](const std::string& file) {
    return "<asset><mesh name='m' file='" + file + "'/></asset>";
  };
  const auto texture = [](const std::string& attribute, const std::string& file, const char* type) {
    return "<asset><texture name='t' type='" + std::string(type) + "' " + attribute + "='" + file +
           "'/></asset>";
  };
  const auto folder = [](const char* which, const std::string& where) {
    return "<compiler " + std::string(which) + "='" + where + "'/>";
  };
  write("model/above.obj", library + "../ours/key.mtl\n" + std::string(kTetrahedron));
  write("model/late.OBJ", std::string(kTetrahedron) + "\r \tmtllib\tlink/key.mtl\r\n");
  // The OBJ reader treats a backslash as a slash; libmujoco needs no dot before "obj".
  write("model/link\\t.obj", "mtllib key.mtl\n" + std::string(kTetrahedron));
  write("model/.obj", "mtllib link/key.mtl\n" + std::string(kTetrahedron));
  write("model/teapotobj", "mtllib link/key.mtl\n" + std::string(kTetrahedron));
  write("model/sub.xml", "<mujoco>" + mesh("../ours/t.obj") + "</mujoco>");
  const struct {
    std::string text, named;
  } cases[] = {
      {mesh("../ours/t.obj"), "ours/t.obj"},
      {mesh((ours / "t.obj").string()), "ours/t.obj"},
      {mesh("link/t.obj"), "link/t.obj"},
      {mesh("link.obj"), "link.obj"},
      {mesh("assets/../../ours/t.obj"), "ours/t.obj"},
      {folder("meshdir", "../ours") + mesh("t.obj"), "ours/t.obj"},
      {folder("meshdir", ours.string()) + mesh("t.obj"), "ours/t.obj"},
      {folder("meshdir", "link") + mesh("t.obj"), "link/t.obj"},
      {"<compiler strippath='true' meshdir='link'/>" + mesh("C:\\robot\\t.obj"), "link/t.obj"},
      {texture("file", "../ours/skin.png", "2d"), "ours/skin.png"},
      {folder("texturedir", "assets/../link") + texture("file", "skin.png", "2d"), "link/skin.png"},
      {texture("fileup", (ours / "skin.png").string(), "cube"), "ours/skin.png"},
      {"<asset><hfield name='h' file='../ours/skin.png' size='1 1 1 1'/></asset>", "ours/skin.png"},
      {"<include file='../ours/parts.xml'/>", "ours/parts.xml"},
      {"<include file='link/parts.xml'/>", "link/parts.xml"},
      {"<include file='sub.xml'/>", "ours/t.obj"},
      {"<Include file='sub.xml'/>", "ours/t.obj"},
      {mesh("above.obj"), "ours/key.mtl"},
      {mesh("late.OBJ"), "link/key.mtl"},
      {mesh("link\\t.obj"), "link/key.mtl"},
      {mesh(".obj"), "link/key.mtl"},
      {mesh("teapotobj"), "link/key.mtl"},
  };
  ReadOptions named;
  named.package_folders = {ours};
  for (const auto& [text, name] : cases) {
    const fs::path file = write("model/model.xml", "<mujoco>" + text + "<worldbody/></mujoco>");
    const Result<Model> read = read_mjcf(file, {});
    ASSERT_FALSE(read.ok()) << text;
    EXPECT_NE(read.error().message.find(name + "\", which lies outside the model's folder"),
              std::string::npos)
        << text << ": " << read.error().message;
    EXPECT_NE(read.error().message.find("--package-path"), std::string::npos) << read.error().message;
    const Result<Model> allowed = read_mjcf(file, named);
    EXPECT_TRUE(allowed.ok()) << text << ": " << (allowed ? "" : allowed.error().message);
  }
  // Files below the folder are read by any path; also if the model itself is reached through a link.
  const fs::path below = write("model/model.xml", "<mujoco>" + folder("meshdir", "assets") +
                                                      mesh("../late.OBJ") + "<worldbody/></mujoco>");
  EXPECT_FALSE(read_mjcf(below, {}).ok()) << "its materials lie outside";
  write("model/late.OBJ", library + "\n" + std::string(kTetrahedron));
  EXPECT_TRUE(read_mjcf(below, {}).ok());
  // Symlink trees of package managers: the resolved folder of the model counts in addition to the link's.
  fs::create_directories(folder_.path() / "tree/assets");
  fs::create_symlink(below, folder_.path() / "tree/model.xml");
  fs::create_symlink(model / "late.OBJ", folder_.path() / "tree/late.OBJ");
  EXPECT_TRUE(read_mjcf(folder_.path() / "tree/model.xml", {}).ok());
}

// libmujoco concatenates folder and file names as text, and has its own rule for absolute paths.
TEST_F(Mjcf, WhereTheProgramWasStartedLiesOutsideToo) {
  namespace fs = std::filesystem;
  constexpr std::string_view kTetrahedron =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (const char* name : {"model/a:start", "start/d:", "start/start"})
    fs::create_directories(folder_.path() / name);
  const auto write = [&](const char* name, const std::string& text) {
    return folder_.write(name, std::string_view(text));
  };
  const fs::path key = write("start/key.mtl", "newmtl secret\n");
  const fs::path parts = write("start/parts.xml", "<mujoco><option/></mujoco>");
  write("start/start/key.mtl", "newmtl secret\n");
  write("start/d:/t.obj", std::string(kTetrahedron));
  write("model/a:start/t.obj", "mtllib key.mtl\n" + std::string(kTetrahedron));
  write("model/t.obj", "mtllib " + key.string() + "\n" + std::string(kTetrahedron));
  const fs::path before = fs::current_path();
  const auto refusal = [&](const char* from, const char* model, const std::string& text) {
    write("model/model.xml", "<mujoco>" + text + "<worldbody/></mujoco>");
    fs::current_path(folder_.path() / from);
    const Result<Model> read = read_mjcf(model, {});
    fs::current_path(before);
    return read.ok() ? std::string("none") : read.error().message;
  };
  const auto mesh = [](const std::string& file) {
    return "<asset><mesh name='m' file='" + file + "'/></asset>";
  };
  const struct {
    const char *from, *model;
    std::string text, named;
  } cases[] = {
      {"start", "../model/model.xml", mesh("d:/t.obj"), "d:/t.obj"},
      {"start", "../model/model.xml", "<compiler meshdir='d:'/>" + mesh("t.obj"), "d:/t.obj"},
      {"start", "../model/model.xml", mesh("a:start/t.obj"), "start/key.mtl"},
      {"model", "model.xml", mesh("t.obj"), "start/key.mtl"},
      {"model", "model.xml", "<include file='" + parts.string() + "'/>", "start/parts.xml"},
  };
  for (const auto& [from, model, text, named] : cases) {
    const std::string message = refusal(from, model, text);
    EXPECT_NE(message.find(named + "\", which lies outside"), std::string::npos) << text << ": " << message;
  }
  EXPECT_NE(refusal("model", "model.xml", mesh("t&#10;.obj")).find("control characters"), std::string::npos);
  const fs::path split = write("model/a\\b.xml", "<mujoco><worldbody/></mujoco>");
  const Result<Model> read = read_mjcf(split, {});
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("holds a backslash"), std::string::npos) << read.error().message;
}

#else

TEST_F(Mjcf, WithoutMuJoCoTheErrorSaysHowToGetIt) {
  const auto model = try_read("<mujoco><option/></mujoco>");
  ASSERT_FALSE(model.ok());
  EXPECT_NE(model.error().message.find("libmujoco-dev"), std::string::npos);
}

#endif

}  // namespace
}  // namespace fire3dv::convert
