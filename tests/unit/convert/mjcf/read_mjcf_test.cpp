// Test of the MJCF reader: bodies as nodes in the first keyframe's pose, visible geoms, cameras and lights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "convert/mjcf/assets/png_pixels.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"
#include "tests/unit/renderer/scene/gltf/model_accessors.h"

namespace fire3dv::convert {
namespace {

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

TEST_F(Mjcf, BodiesRestInFirstKeyframe) {
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

TEST_F(Mjcf, VisibleGeomGroupsHaveSizes) {
  const Model model = checked(try_read(kArm));
  const auto [box_low, box_high] = bounds(model.meshes[*node(model, "shoulder").mesh]);
  EXPECT_LT(glm::distance(box_low, glm::vec3(-0.1f, -0.2f, 0)), 1e-6f);
  EXPECT_LT(glm::distance(box_high, glm::vec3(0.1f, 0.2f, 0.6f)), 1e-6f);
  const auto [low, high] = bounds(model.meshes[*node(model, "body_2").mesh]);  // neither group 3 nor alpha 0
  EXPECT_LT(glm::distance(low, glm::vec3(-0.1f, -0.1f, -0.5f)), 1e-6f);
  EXPECT_LT(glm::distance(high, glm::vec3(0.1f, 0.1f, 0.5f)), 1e-6f);
  EXPECT_GT(bounds(model.meshes[*node(model, "world").mesh]).second.x, 500);  // an infinite plane
}

TEST_F(Mjcf, InfinitePlanesReachTheHorizon) {
  const Model model = checked(try_read(R"(<mujoco><statistic extent="2"/>
    <asset><texture name="t" type="2d" builtin="checker" width="4" height="4"/>
      <material name="m" texture="t" texrepeat="3 5"/></asset>
    <worldbody><geom name="floor" type="plane" size="0 4 1" material="m"/><geom name="table" type="box" size="1 1 1"/>
      <body name="b"><geom type="plane" size="2 4 1"/></body></worldbody></mujoco>)"));
  EXPECT_FALSE(model.meshes[*node(model, "world").mesh].unbounded);
  EXPECT_FALSE(model.meshes[*node(model, "b").mesh].unbounded);
  const Node& floor = node(model, "floor");  // apart from the table
  EXPECT_EQ(model.nodes[*floor.parent].name, "world");
  const Mesh& mesh = model.meshes[*floor.mesh];
  EXPECT_TRUE(mesh.unbounded);
  EXPECT_EQ(bounds(mesh).first, glm::vec3(-2500, -4, 0));
  EXPECT_EQ(bounds(mesh).second, glm::vec3(2500, 4, 0));
  const Surface& s = mesh.surfaces.at(0);
  EXPECT_EQ(s.indices.size(), 7 * 2 * 3u);
  for (size_t v = 0; v < s.positions.size(); ++v) {
    EXPECT_NEAR(s.uvs[v].x, 0.5f + 1.5f * s.positions[v].x, 1e-3f) << "per unit of length";
    EXPECT_NEAR(s.uvs[v].y, 0.5f - 2.5f * s.positions[v].y / 4, 1e-3f) << "over the size";
  }
  EXPECT_EQ(node(checked(try_read(kArm)), "world").mesh.has_value(), true)
      << "a floor alone is its body's mesh";
}

// A gradient from the zenith to the nadir, and faces of single files, whose directions are those of glTF.
TEST_F(Mjcf, SkyboxesAreImagesAround) {
  const auto sky = [&](const std::string& texture) {
    const Model model =
        checked(try_read("<mujoco><asset><texture type='2d' name='t' builtin='flat' width='4' height='4'/>" +
                         texture + "</asset><worldbody><geom size='1'/></worldbody></mujoco>"));
    if (!model.sky_image) return PngPixels();
    Result<PngPixels> pixels = decode_png(model.images.at(*model.sky_image).bytes);
    EXPECT_TRUE(pixels) << pixels.error().message;
    return pixels ? std::move(*pixels) : PngPixels();
  };
  const auto pixel = [](const PngPixels& image, double x, double y) {
    const auto column = static_cast<size_t>(x * image.width), row = static_cast<size_t>(y * image.height);
    const size_t first = 3 * (row * image.width + column);
    return glm::ivec3(image.rgb[first], image.rgb[first + 1], image.rgb[first + 2]);
  };
  EXPECT_TRUE(sky("").rgb.empty());
  const PngPixels gradient =
      sky("<texture type='skybox' builtin='gradient' rgb1='1 0 0' rgb2='0 0 1' width='32' height='192'/>");
  ASSERT_FALSE(gradient.rgb.empty());
  EXPECT_NEAR(pixel(gradient, 0.5, 0.001).r, 255, 3);
  EXPECT_NEAR(pixel(gradient, 0.5, 0.999).b, 255, 3);
  EXPECT_NEAR(pixel(gradient, 0.5, 0.5).x, 127, 8);
  const char* sides[] = {"fileright", "fileleft", "fileup", "filedown", "filefront", "fileback"};
  std::string files;
  for (size_t i = 0; i < 6; ++i) {
    const std::string name = std::string(sides[i]) + ".png";
    folder_.write(name, test::png(4, 4, static_cast<uint32_t>(0xff000000 | 40 * (i + 1))));
    files += std::string(" ") + sides[i] + "='" + name + "'";
  }
  const PngPixels faces = sky("<texture type='skybox' name='box'" + files + "/>");
  ASSERT_FALSE(faces.rgb.empty());
  EXPECT_EQ(faces.width, 2 * faces.height);
  // -Z of glTF, where its cameras look, is in the middle.
  EXPECT_EQ(pixel(faces, 0.5, 0.5).x, 240) << "back";
  EXPECT_EQ(pixel(faces, 0.75, 0.5).x, 40) << "right";
  EXPECT_EQ(pixel(faces, 0.25, 0.5).x, 80) << "left";
  EXPECT_EQ(pixel(faces, 0.01, 0.5).x, 200) << "front";
  EXPECT_EQ(pixel(faces, 0.5, 0.05).x, 120) << "up";
  EXPECT_EQ(pixel(faces, 0.5, 0.95).x, 160) << "down";
  folder_.write("strip.png", test::png(8, 4, 0xff996633));
  EXPECT_EQ(pixel(sky("<texture type='skybox' file='strip.png' gridsize='1 2' gridlayout='UD'/>"), 0.5, 0.05),
            glm::ivec3(0x33, 0x66, 0x99));
  const Result<Model> missing = try_read(
      "<mujoco><asset><texture type='skybox' file='gone.png'/></asset><worldbody><geom "
      "size='1'/></worldbody></mujoco>");
  ASSERT_TRUE(missing);
  EXPECT_FALSE(missing->sky_image);
  ASSERT_EQ(missing->warnings.size(), 1u);
  EXPECT_NE(missing->warnings[0].find("the sky is left out"), std::string::npos) << missing->warnings[0];
}

TEST_F(Mjcf, BodiesOwnCamerasAndLights) {
  const Model model = checked(try_read(kArm));
  EXPECT_EQ(model.nodes[0].name, "overview");
  EXPECT_EQ(model.nodes[1].name, "free camera");
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

TEST_F(Mjcf, MaterialsMatchTheModel) {
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
  // Five sides are red; the lower one has the default second colour, half of white.
  const float mean_blue = linear_from_srgb(glm::vec3(0.5f)).b / 6;
  EXPECT_LT(glm::distance(cubed.base_color, glm::vec4(0, 0, mean_blue, 1)), 1e-4f);
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("\"sky\" is a cube"), std::string::npos);
  for (const char* file : {"model.xml", "parts.xml", "assets/t.obj", "assets/skin.png"})
    EXPECT_TRUE(model.sources.contains(folder_.path() / file)) << file;
}

TEST_F(Mjcf, HeightFieldHasTopAndWalls) {
  const Model model =
      checked(try_read(R"(<mujoco><asset><hfield name="h" nrow="2" ncol="3" size="3 2 1 0.5"/></asset>
    <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>)"));
  const auto [low, high] = bounds(model.meshes[0]);
  EXPECT_EQ(low, glm::vec3(-3, -2, -0.5f));
  EXPECT_EQ(glm::vec2(high), glm::vec2(3, 2));
  EXPECT_EQ(model.meshes[0].surfaces[0].indices.size() / 3, 4u + 2 * 6u);
}

TEST_F(Mjcf, TriangleLimitIsReported) {
  std::string bodies;
  for (int i = 0; i < 30; ++i)
    bodies += "<body><geom type='box' size='1 1 " + std::to_string(1 + i / 2) + "'/></body>";
  ReadOptions options;
  options.max_triangles = 100;
  const Model model = checked(try_read("<mujoco><worldbody>" + bodies + "</worldbody></mujoco>", options));
  EXPECT_EQ(model.meshes.size(), 9u) << "12 triangles each, for two bodies each";
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("those after it lack geoms: the scene has more than 100 triangles"),
            std::string::npos)
      << model.warnings[0];
}

TEST_F(Mjcf, ErrorsNameFileAndLine) {
  const auto error_of = [&](const std::string& text) {
    const auto model = try_read(text);
    EXPECT_FALSE(model.ok()) << text;
    return model ? "" : model.error().message;
  };
  const auto warnings_of = [&](const std::string& text) {
    std::string all;
    for (const std::string& warning : checked(try_read(text)).warnings) all += warning + "\n";
    return all;
  };
  const auto holds = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  holds(warnings_of("<mujoco>\n<worldbody>\n<blob/>\n</worldbody></mujoco>"), "model.xml\", line 3: blob");
  holds(warnings_of("<mujoco><asset><mesh name='m' file='gone.stl'/></asset><worldbody>"
                    "<geom type='mesh' mesh='m'/></worldbody></mujoco>"),
        "gone.stl\" does not exist");
  holds(warnings_of("<mujoco>\n<worldbody><geom name='g' type='box' size='1 x 1'/></worldbody></mujoco>"),
        "line 2: geom \"g\": size=\"1 x 1\"");
  holds(warnings_of("<mujoco><worldbody><geom class='none' size='1'/></worldbody></mujoco>"),
        "no default class \"none\"");
  const std::string broken = error_of("<mujoco>\n<worldbody>\n");
  holds(broken, "model.xml");
  holds(error_of("<mujoco><compiler coordinate='global'/></mujoco>"), "coordinate=\"global\"");
  folder_.write("loop.xml", std::string_view("<mujoco><include file='loop.xml'/></mujoco>"));
  holds(error_of("<mujoco><include file='loop.xml'/><worldbody/></mujoco>"), "loop.xml\" includes itself");
  holds(error_of("<mujoco><worldbody><replicate count='1000000'><replicate count='1000000'><geom size='1'/>"
                 "</replicate></replicate></worldbody></mujoco>"),
        "more than 1000000");
}

// Security: a confined model names files outside of its folder, in several disguises; none of them is read.
TEST_F(Mjcf, ConfinedModelsReadTheirFoldersAlone) {
  namespace fs = std::filesystem;
  const fs::path model = folder_.path() / "model", ours = folder_.path() / "ours";
  fs::create_directories(model / "assets");
  fs::create_directories(ours);
  folder_.write("ours/t.obj",
                std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"));
  folder_.write("ours/skin.png", test::png(2, 2, 0x00ff00ff));
  folder_.write("ours/parts.xml",
                std::string_view("<mujoco><worldbody><body name='inside'/></worldbody></mujoco>"));
  fs::create_symlink(ours, model / "link");
  fs::create_symlink(ours / "t.obj", model / "link.obj");
  folder_.write("model/sub.xml",
                std::string_view("<mujoco><asset><mesh name='m' file='../ours/t.obj'/></asset></mujoco>"));
  const std::string shown = "<worldbody><geom type='mesh' mesh='m'/></worldbody>";
  const auto mesh = [&](const std::string& file) {
    return "<asset><mesh name='m' file='" + file + "'/></asset>" + shown;
  };
  const auto texture = [](const std::string& attribute, const std::string& file, const char* type) {
    return "<asset><texture name='t' type='" + std::string(type) + "' " + attribute + "='" + file +
           "'/><material name='m' texture='t'/></asset><worldbody><geom size='1' material='m'/></worldbody>";
  };
  const struct {
    std::string text, named;
  } cases[] = {
      {mesh("../ours/t.obj"), "ours/t.obj"},
      {mesh((ours / "t.obj").string()), "ours/t.obj"},
      {mesh("..\\ours\\t.obj"), "ours/t.obj"},
      {mesh("link/t.obj"), "link/t.obj"},
      {mesh("link.obj"), "link.obj"},
      {"<compiler meshdir='assets/../../ours'/>" + mesh("t.obj"), "ours/t.obj"},
      {"<compiler meshdir='" + ours.string() + "'/>" + mesh("t.obj"), "ours/t.obj"},
      {"<compiler strippath='true' meshdir='link'/>" + mesh("C:\\robot\\t.obj"), "link/t.obj"},
      {texture("file", "../ours/skin.png", "2d"), "ours/skin.png"},
      {texture("fileup", (ours / "skin.png").string(), "cube"), "ours/skin.png"},
      {"<compiler texturedir='link'/>" + texture("file", "skin.png", "2d"), "link/skin.png"},
      {"<asset><hfield name='h' file='../ours/skin.png' size='1 1 1 1'/></asset><worldbody>"
       "<geom type='hfield' hfield='h'/></worldbody>",
       "ours/skin.png"},
      {"<include file='sub.xml'/>" + shown, "ours/t.obj"},
      {"<asset><model name='a' file='../ours/parts.xml'/></asset><worldbody><attach model='a' "
       "prefix='x'/></worldbody>",
       "ours/parts.xml"},
  };
  ReadOptions confined, named;
  confined.is_confined = named.is_confined = true;
  named.package_folders = {ours};
  for (const auto& [text, name] : cases) {
    const fs::path file = folder_.write("model/model.xml", std::string_view("<mujoco>" + text + "</mujoco>"));
    const Model read = checked(read_mjcf(file, confined));
    const bool is_reported =
        std::any_of(read.warnings.begin(), read.warnings.end(), [&, &part = name](const std::string& w) {
          return w.find(part + "\" lies outside the model's folder") != std::string::npos &&
                 w.find("--package-path") != std::string::npos;
        });
    EXPECT_TRUE(is_reported) << text;
    EXPECT_TRUE(read.images.empty()) << text;
    for (const std::string& warning : checked(read_mjcf(file, named)).warnings)
      EXPECT_EQ(warning.find("lies outside"), std::string::npos) << text << ": " << warning;
  }
  for (const char* include : {"../ours/parts.xml", "link/parts.xml"}) {
    const std::string text = "<mujoco><Include file='" + std::string(include) + "'/></mujoco>";
    const fs::path file = folder_.write("model/model.xml", std::string_view(text));
    const Result<Model> read = read_mjcf(file, confined);
    ASSERT_FALSE(read.ok()) << include;
    EXPECT_NE(read.error().message.find("lies outside the model's folder"), std::string::npos)
        << read.error().message;
    EXPECT_TRUE(read_mjcf(file, named).ok());
  }
  // Symlink trees of package managers: the resolved folder of the model counts in addition to the link's.
  folder_.write("model/t.obj", std::string_view("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  const fs::path below =
      folder_.write("model/model.xml", std::string_view("<mujoco>" + mesh("t.obj") + "</mujoco>"));
  fs::create_directories(folder_.path() / "tree");
  fs::create_symlink(below, folder_.path() / "tree/model.xml");
  fs::create_symlink(model / "t.obj", folder_.path() / "tree/t.obj");
  EXPECT_TRUE(checked(read_mjcf(folder_.path() / "tree/model.xml", confined)).warnings.empty());
}

}  // namespace
}  // namespace fire3dv::convert
