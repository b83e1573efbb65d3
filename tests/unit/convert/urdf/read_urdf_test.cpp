// Test of the URDF reader: links as nodes, joints at rest, geometry, materials, and file resolution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/renderer/scene/gltf/model_accessors.h"

namespace fire3dv::convert {
namespace {

constexpr std::string_view kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

class Urdf : public testing::Test {
 protected:
  Result<Model> try_read(const std::string& text, const ReadOptions& options = {}) {
    std::filesystem::create_directories(folder_.path() / "arm_description/urdf");
    return read_urdf(folder_.write("arm_description/urdf/arm.urdf", std::string_view(text)), options);
  }
  Model read(const std::string& inside, const ReadOptions& options = {}) {
    auto model = try_read("<?xml version=\"1.0\"?>\n<robot name=\"arm\">\n" + inside + "</robot>\n", options);
    EXPECT_TRUE(model.ok()) << model.error().message;
    return model ? std::move(*model) : Model();
  }
  void write(const std::string& name, std::string_view text) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, text);
  }
  std::string error_of(const std::string& text) {
    const auto model = try_read(text);
    EXPECT_FALSE(model.ok()) << text;
    return model ? "" : model.error().message;
  }
  test::ScratchFolder folder_;
};

std::string visual(const std::string& geometry, const std::string& more = "") {
  return "<visual><origin xyz=\"0 0 1\"/><geometry>" + geometry + "</geometry>" + more + "</visual>";
}
std::string link(const std::string& name, const std::string& inside = "") {
  return "<link name=\"" + name + "\">" + inside + "</link>\n";
}
std::string joint(const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& inside = "") {
  return "<joint name=\"" + parent + child + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

TEST_F(Urdf, WherePackagesAreMissingIsRecorded) {
  ReadOptions options;
  options.package_folders = {folder_.path() / "ws"};
  const Model model = read(link("base", visual("<mesh filename=\"package://gone/a.obj\"/>") +
                                            visual("<mesh filename=\"package://gone/b.obj\"/>")),
                           options);
  for (const std::string place : {"ws/gone", "arm_description/urdf/gone", "arm_description/gone", "gone"}) {
    const auto path = std::filesystem::canonical(folder_.path()) / place;
    EXPECT_TRUE(model.sources.contains(path)) << path;
  }
}

TEST_F(Urdf, LinksRestAtJoints) {
  const std::string limits = "<limit lower=\"0.5\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
  const Model model =
      read(link("base") + link("turned") + link("limited") + link("pushed") +
           joint("fixed", "base", "turned", "<origin xyz=\"1 2 3\" rpy=\"0 0 1.5707963267948966\"/>") +
           joint("revolute", "turned", "limited", "<axis xyz=\"0 0 2\"/>" + limits) +
           joint("prismatic", "turned", "pushed",
                 "<origin rpy=\"0 1.5707963267948966 0\"/><axis xyz=\"0 0 1\"/>" + limits));
  ASSERT_EQ(model.nodes.size(), 4u);
  EXPECT_EQ(model.name, "arm");
  EXPECT_FALSE(model.nodes[0].parent);
  EXPECT_EQ(model.nodes[*node(model, "limited").parent].name, "turned");
  EXPECT_EQ(node(model, "turned").translation, glm::dvec3(1, 2, 3));
  EXPECT_LT(glm::distance(node(model, "turned").rotation * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)), 1e-9);
  // 0 is outside of both joints' limits: they rest at 0.5.
  EXPECT_LT(glm::distance(node(model, "limited").rotation * glm::dvec3(1, 0, 0),
                          glm::dvec3(std::cos(0.5), std::sin(0.5), 0)),
            1e-9);
  EXPECT_LT(glm::distance(node(model, "pushed").translation, glm::dvec3(0.5, 0, 0)), 1e-9);
}

TEST_F(Urdf, ShapesHaveSizesThatUrdfMeans) {
  const Model model = read(link("a", visual("<box size=\"1 2 3\"/>")) +
                           link("b", visual("<cylinder radius=\"0.5\" length=\"3\"/>")) +
                           link("c", visual("<sphere radius=\"0.25\"/>")) + joint("fixed", "a", "b") +
                           joint("fixed", "b", "c"));
  ASSERT_EQ(model.meshes.size(), 3u);
  EXPECT_EQ(bounds(model.meshes[0]), std::make_pair(glm::vec3(-0.5f, -1, -0.5f), glm::vec3(0.5f, 1, 2.5f)));
  EXPECT_EQ(bounds(model.meshes[1]),
            std::make_pair(glm::vec3(-0.5f, -0.5f, -0.5f), glm::vec3(0.5f, 0.5f, 2.5f)));
  EXPECT_EQ(bounds(model.meshes[2]),
            std::make_pair(glm::vec3(-0.25f, -0.25f, 0.75f), glm::vec3(0.25f, 0.25f, 1.25f)));
}

TEST_F(Urdf, MaterialsResolveByName) {
  const Model model =
      read("<material name=\"half\"><color rgba=\"0.5 1 0 0.25\"/></material>\n" +
           link("a", visual("<box size=\"1 1 1\"/>", "<material name=\"half\"/>") +
                         visual("<sphere radius=\"1\"/>",
                                "<material name=\"own\"><color rgba=\"0 0 1 1\"/></material>") +
                         visual("<sphere radius=\"2\"/>")));
  ASSERT_EQ(model.meshes[0].surfaces.size(), 3u);
  const Material& half = model.materials[model.meshes[0].surfaces[0].material];
  EXPECT_NEAR(half.base_color.r, 0.21404f, 1e-4f);
  EXPECT_EQ(half.base_color.g, 1);
  EXPECT_EQ(half.base_color.a, 0.25f);
  EXPECT_TRUE(half.blended);
  const Material& own = model.materials[model.meshes[0].surfaces[1].material];
  EXPECT_EQ(own.base_color, glm::vec4(0, 0, 1, 1));
  EXPECT_FALSE(own.blended);
}

TEST_F(Urdf, MeshUrisAreResolved) {
  write("arm_description/meshes/t.obj", kTetrahedron);
  write("elsewhere/tools/meshes/t.obj", kTetrahedron);
  write("arm_description/urdf/t.obj", kTetrahedron);
  const auto mesh = [](const std::string& uri) {
    return visual("<mesh filename=\"" + uri + "\" scale=\"1 -2 1\"/>");
  };
  ReadOptions options;
  options.package_folders = {folder_.path() / "elsewhere"};
  const Model model =
      read(link("own", mesh("package://arm_description/meshes/t.obj")) +
               link("other", mesh("package://tools/meshes/t.obj")) + link("beside", mesh("t.obj")) +
               link("above", mesh("../meshes/t.obj")) +
               link("uri", mesh("file://" + (folder_.path() / "elsewhere/tools/meshes/t.obj").string())) +
               joint("fixed", "own", "other") + joint("fixed", "own", "beside") +
               joint("fixed", "own", "above") + joint("fixed", "own", "uri"),
           options);
  EXPECT_TRUE(model.warnings.empty()) << model.warnings.front();
  ASSERT_EQ(model.nodes.size(), 5u);
  for (const Node& each : model.nodes) {
    ASSERT_TRUE(each.mesh) << each.name;
    EXPECT_EQ(bounds(model.meshes[*each.mesh]), std::make_pair(glm::vec3(0, -2, 1), glm::vec3(1, 0, 2)))
        << each.name;
  }
  EXPECT_EQ(model.meshes.size(), 3u) << "one for each file";
}

// The rule of RViz.
TEST_F(Urdf, MeshMaterialsOverrideLinks) {
  write("arm_description/urdf/with.obj", "mtllib a.mtl\nusemtl red\n" + std::string(kTetrahedron));
  write("arm_description/urdf/without.obj", kTetrahedron);
  write("arm_description/urdf/a.mtl", "newmtl red\nKd 1 0 0\n");
  const std::string blue = "<material name=\"blue\"><color rgba=\"0 0 1 1\"/></material>";
  const Model model =
      read(link("a", visual("<mesh filename=\"with.obj\"/>", blue)) +
           link("b", visual("<mesh filename=\"without.obj\"/>", blue)) + joint("fixed", "a", "b"));
  ASSERT_EQ(model.meshes.size(), 2u);
  const auto color = [&](const char* name) {
    return model.materials[model.meshes[*node(model, name).mesh].surfaces[0].material].base_color;
  };
  EXPECT_EQ(color("a"), glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(color("b"), glm::vec4(0, 0, 1, 1));
}

TEST_F(Urdf, MissingFilesKeepLinks) {
  const Model model =
      read(link("base", visual("<box size=\"1 1 1\"/>") + visual("<mesh filename=\"gone.stl\"/>")) +
           link("bare", visual("<mesh filename=\"package://nowhere/x.dae\"/>")) +
           link("web", visual("<mesh filename=\"https://example.org/x.dae\"/>")) +
           joint("fixed", "base", "bare") + joint("fixed", "base", "web"));
  EXPECT_EQ(model.nodes.size(), 3u);
  EXPECT_EQ(model.meshes.size(), 1u);
  ASSERT_EQ(model.warnings.size(), 3u);
  EXPECT_NE(model.warnings[0].find("arm.urdf: link \"base\": "), std::string::npos) << model.warnings[0];
  EXPECT_NE(model.warnings[0].find("gone.stl"), std::string::npos) << model.warnings[0];
  EXPECT_NE(
      model.warnings[1].find("\"nowhere\" is not found: name the folder that holds it with --package-path"),
      std::string::npos)
      << model.warnings[1];
  EXPECT_NE(model.warnings[2].find("https://example.org"), std::string::npos) << model.warnings[2];
  EXPECT_TRUE(
      model.sources.contains(std::filesystem::canonical(folder_.path()) / "arm_description/urdf/gone.stl"));
}

constexpr const char* kManifest = "<package><!-- <name>no</name> -->\n<name> %s </name></package>";
std::string manifest(const std::string& name) {
  std::string text = kManifest;
  return text.replace(text.find("%s"), 2, name);
}

TEST_F(Urdf, PackagesResolveByManifest) {
  write("arm_description/package.xml", manifest("real_arm"));  // the folder's name differs
  write("arm_description/meshes/t.obj", kTetrahedron);
  write("gripper-master/package.xml", manifest("gripper"));  // beside the URDF's package
  write("gripper-master/t.obj", kTetrahedron);
  write("ws/src/repository/hand_files/package.xml", manifest("hand"));  // below a named folder
  write("ws/src/repository/hand_files/t.obj", kTetrahedron);
  write("ros/nested/foot/t.obj", kTetrahedron);
  write("ros/nested/foot/package.xml", manifest("foot"));
  write("ros/ignored/head/package.xml", manifest("head"));
  write("ros/ignored/head/t.obj", kTetrahedron);
  write("ros/ignored/COLCON_IGNORE", "");
  write("prefix/share/eye/t.obj", kTetrahedron);
  std::filesystem::create_directory_symlink(folder_.path() / "ws", folder_.path() / "ws/src/cycle");
  ReadOptions options;
  options.package_folders = {folder_.path() / "ws"};
  const auto reads = [&](const std::string& uri) {
    return read(link("a", visual("<mesh filename=\"" + uri + "\"/>")), options).warnings.empty();
  };
  EXPECT_TRUE(reads("package://real_arm/meshes/t.obj"));
  EXPECT_TRUE(reads("model://real_arm/meshes/t.obj"));
  EXPECT_TRUE(reads("$(find real_arm)/meshes/t.obj"));
  EXPECT_TRUE(reads("file://$(find real_arm)/meshes/t.obj"));
  EXPECT_TRUE(reads("package://arm_description/meshes/t.obj"));
  EXPECT_TRUE(reads("package://gripper/t.obj"));
  EXPECT_TRUE(reads("package://hand/t.obj"));
  EXPECT_TRUE(reads("..\\meshes\\t.obj"));
  EXPECT_TRUE(reads("../mesh%65s/t.obj"));
  EXPECT_FALSE(reads("package://foot/t.obj"));
  EXPECT_FALSE(reads("package://eye/t.obj"));
  EXPECT_FALSE(reads("package://../t.obj"));
  EXPECT_FALSE(reads("$(find real_arm)"));
  setenv("ROS_PACKAGE_PATH", ("relative:" + (folder_.path() / "ros").string()).c_str(), 1);
  setenv("AMENT_PREFIX_PATH", ("/nowhere:" + (folder_.path() / "prefix").string()).c_str(), 1);
  EXPECT_TRUE(reads("package://foot/t.obj"));
  EXPECT_TRUE(reads("package://eye/t.obj"));
  EXPECT_FALSE(reads("package://head/t.obj"));
  unsetenv("ROS_PACKAGE_PATH");
  unsetenv("AMENT_PREFIX_PATH");
}

TEST_F(Urdf, UnknownPackagesMatchBySuffix) {
  write("arm_description/meshes/t.obj", kTetrahedron);
  const auto first_warning = [&](const std::string& uri) {
    const Model model = read(
        link("a", visual("<mesh filename=\"" + uri + "\"/>") + visual("<mesh filename=\"" + uri + "\"/>")));
    EXPECT_EQ(model.meshes.size(), 1u) << uri;
    EXPECT_EQ(model.warnings.size(), 1u) << uri;
    return model.warnings.empty() ? "" : model.warnings[0];
  };
  const std::string package = first_warning("package://lost/meshes/t.obj");
  EXPECT_NE(package.find("\"lost\" is not found: name the folder"), std::string::npos) << package;
  EXPECT_NE(package.find("arm_description/meshes/t.obj\" is used for"), std::string::npos) << package;
  const std::string absolute = first_warning("file:///home/somebody/ws/lost/meshes/t.obj");
  EXPECT_NE(absolute.find("with the same end, is used instead"), std::string::npos) << absolute;
  // A name alone is no evidence, and a path may not leave the folders.
  for (const char* uri : {"file:///home/t.obj", "package://lost/../arm_description/meshes/t.obj"})
    EXPECT_TRUE(read(link("a", visual("<mesh filename=\"" + std::string(uri) + "\"/>"))).meshes.empty())
        << uri;
}

TEST_F(Urdf, ValuesThatOthersAcceptAreRepaired) {
  write("arm_description/urdf/t.obj", kTetrahedron);
  const std::string inertia = "<inertial><mass/><inertia ixx=\"?\"/></inertial>";
  const auto model =
      try_read("<robot>" + link("a", visual("<mesh filename=\"t.obj\" scale=\" 0.5 \"/>") + inertia) +
               link("b") + link("c") + joint("prismatic", "a", "b", "<axis xyz=\"0 0 1\"/>") +
               joint("revolute", "a", "c", "<limit lower=\"0.5\" upper=\"1\"/>") +
               "<transmission><joint/></transmission></robot>");
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(model->name, "arm");
  EXPECT_EQ(bounds(model->meshes.at(0)), std::make_pair(glm::vec3(0, 0, 1), glm::vec3(0.5f, 0.5f, 1.5f)));
  EXPECT_EQ(node(*model, "b").translation, glm::dvec3(0));
  EXPECT_NEAR(glm::angle(node(*model, "c").rotation), 0.5, 1e-9);
  ASSERT_EQ(model->warnings.size(), 2u);
  EXPECT_NE(model->warnings[0].find("the robot has no name; it is called \"arm\""), std::string::npos);
  EXPECT_NE(model->warnings[1].find("joint \"ab\" should have a <limit>"), std::string::npos);
}

TEST_F(Urdf, EmptyResultNamesReason) {
  const auto last_warning = [&](const std::string& inside) {
    const Model model = read(inside);
    EXPECT_TRUE(model.meshes.empty());
    return model.warnings.empty() ? "" : model.warnings.back();
  };
  const std::string collision = "<collision><geometry><box size=\"1 1 1\"/></geometry></collision>";
  EXPECT_NE(last_warning(link("a")).find("nothing to draw: no link has a <visual>; "), std::string::npos);
  EXPECT_NE(last_warning(link("a", collision)).find("no link has a <visual>, only <collision>"),
            std::string::npos);
  const std::string gone = visual("<mesh filename=\"package://gone/a.stl\"/>");
  EXPECT_NE(last_warning(link("a", gone)).find("its only mesh is missing (see above); name the folder"),
            std::string::npos);
  EXPECT_NE(last_warning(link("a", gone + gone)).find("all 2 meshes are missing"), std::string::npos);
  write("arm_description/urdf/bad.obj", "nothing");
  EXPECT_NE(last_warning(link("a", gone + visual("<mesh filename=\"bad.obj\"/>")))
                .find("none of its 2 visuals can be read"),
            std::string::npos);
  EXPECT_TRUE(read(link("a", visual("<sphere radius=\"1\"/>"))).warnings.empty());
}

TEST_F(Urdf, TexturesAreRead) {
  std::filesystem::create_directories(folder_.path() / "arm_description/urdf");
  folder_.write("arm_description/urdf/skin.png", test::png(2, 2, 0x00ff00ff));
  const Model model =
      read(link("a", visual("<box size=\"1 1 1\"/>",
                            "<material name=\"m\"><texture filename=\"skin.png\"/></material>")));
  ASSERT_EQ(model.images.size(), 1u);
  EXPECT_EQ(model.images[0].name, "skin.png");
  const Material& material = model.materials[model.meshes[0].surfaces[0].material];
  EXPECT_EQ(material.base_color_image, 0u);
  EXPECT_EQ(material.base_color, glm::vec4(1));
}

// Security: an untrusted URDF may name any file, and an image becomes part of the scene.
TEST_F(Urdf, TexturesOfOthersAreNotRead) {
  for (const char* name :
       {"private/me.png", "arm_description/textures/skin.png", "other/textures/skin.png"}) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    folder_.write(name, test::png(2, 2, 0x00ff00ff));
  }
  const auto read_texture = [&](const std::string& uri, const ReadOptions& options = {}) {
    const Model model =
        read(link("a", visual("<box size=\"1 1 1\"/>",
                              "<material name=\"m\"><texture filename=\"" + uri + "\"/></material>")),
             options);
    EXPECT_EQ(model.warnings.size(), model.images.empty() ? 1u : 0u) << uri;
    if (model.images.empty()) {
      EXPECT_NE(model.warnings.at(0).find("lies outside"), std::string::npos) << model.warnings.at(0);
    }
    return !model.images.empty();
  };
  EXPECT_FALSE(read_texture("file://" + (folder_.path() / "private/me.png").string()));
  EXPECT_FALSE(read_texture("../../private/me.png"));
  // Any parent folder could be named as a package.
  EXPECT_FALSE(read_texture("package://private/me.png"));
  EXPECT_FALSE(read_texture("package://" + folder_.path().filename().string() + "/private/me.png"));
  // Allowed in folders that the user names, and in packages.
  ReadOptions options;
  options.package_folders = {folder_.path() / "private"};
  EXPECT_TRUE(read_texture("../../private/me.png", options));
  EXPECT_FALSE(read_texture("../textures/skin.png"));
  EXPECT_FALSE(read_texture("package://other/textures/skin.png"));
  write("arm_description/package.xml", "<package/>");
  write("other/package.xml", "<package/>");
  EXPECT_TRUE(read_texture("../textures/skin.png"));
  EXPECT_TRUE(read_texture("package://other/textures/skin.png"));
  EXPECT_FALSE(read_texture("../../other/textures/skin.png")) << "its package was not named";
  std::filesystem::create_symlink(folder_.path() / "private/me.png",
                                  folder_.path() / "arm_description/urdf/link.png");
  EXPECT_FALSE(read_texture("link.png"));
}

// Security: a confined URDF names meshes outside of its folder, in several disguises; none of them is read.
TEST_F(Urdf, ConfinedReadsNamedFoldersOnly) {
  for (const char* name : {"private/t.obj", "private/part/t.obj", "ament/share/parts/t.obj"})
    write(name, kTetrahedron);
  write("arm_description/urdf/own.obj", kTetrahedron);
  write("private/part/package.xml", "<package><name>part</name></package>");
  ::unsetenv("ROS_PACKAGE_PATH");
  ::setenv("AMENT_PREFIX_PATH", (folder_.path() / "ament").c_str(), 1);
  ReadOptions confined, named;
  confined.is_confined = named.is_confined = true;
  named.package_folders = {folder_.path() / "private"};
  const auto warnings_of = [&](const std::string& uri, const ReadOptions& options) {
    const Model model = read(link("a", visual("<mesh filename=\"" + uri + "\"/>")), options);
    std::string text;
    for (const std::string& warning : model.warnings) text += warning + '\n';
    EXPECT_EQ(model.meshes.empty(), !text.empty()) << uri << ": " << text;
    return text;
  };
  const std::string folder = folder_.path().string();
  for (const std::string& uri : {folder + "/private/t.obj", "file://" + folder + "/private/t.obj",
                                 "file://" + folder + "/private/gone.obj", std::string("../../private/t.obj"),
                                 "file://" + folder + "/arm_description/urdf/../../private/t.obj",
                                 "file://" + folder + "/%70rivate/t.obj"}) {
    const std::string text = warnings_of(uri, confined);
    EXPECT_NE(text.find("\"" + uri +
                        "\" lies outside the folders that a description of unknown origin may "
                        "name files of: name its folder with --package-path"),
              std::string::npos)
        << text;
  }
  // Every folder above the description could be named as a package.
  const std::vector<std::string> packages = {
      "package://private/t.obj", "package:/" + folder + "/private/t.obj",
      "package://parts/../../../private/t.obj", "$(find private)/t.obj"};
  for (const std::string& uri : packages) EXPECT_NE(warnings_of(uri, confined), "") << uri;
  EXPECT_EQ(warnings_of("package://parts/t.obj", confined), "") << "an installed package";
  EXPECT_EQ(warnings_of("own.obj", confined), "");
  EXPECT_EQ(warnings_of("file://" + folder + "/private/t.obj", named), "");
  EXPECT_EQ(warnings_of("package://part/t.obj", named), "");
  EXPECT_EQ(warnings_of("file://" + folder + "/private/t.obj", {}), "") << "the user's own file";
  ::unsetenv("AMENT_PREFIX_PATH");
}

TEST_F(Urdf, LinksThatLookAlikeShareMesh) {
  const std::string grey = "<material name=\"grey\"><color rgba=\"0.5 0.5 0.5 1\"/></material>";
  const Model model = read(
      link("a", visual("<sphere radius=\"1\"/>", grey)) + link("b", visual("<sphere radius=\"1\"/>", grey)) +
      link("c", visual("<sphere radius=\"2\"/>", grey)) + link("d", visual("<sphere radius=\"1\"/>")) +
      joint("fixed", "a", "b") + joint("fixed", "a", "c") + joint("fixed", "a", "d"));
  EXPECT_EQ(model.meshes.size(), 3u);
  EXPECT_EQ(node(model, "a").mesh, node(model, "b").mesh);
  EXPECT_NE(node(model, "a").mesh, node(model, "c").mesh);
  EXPECT_NE(node(model, "a").mesh, node(model, "d").mesh) << "another material";
}

TEST_F(Urdf, TriangleLimitIsReported) {
  std::string inside = link("l0", visual("<box size=\"1 1 1\"/>"));
  for (int i = 1; i < 30; ++i)
    inside += link("l" + std::to_string(i), visual("<box size=\"1 1 " + std::to_string(i) + ".5\"/>")) +
              joint("fixed", "l0", "l" + std::to_string(i));
  ReadOptions options;
  options.max_triangles = 100;
  const Model model = read(inside, options);
  EXPECT_EQ(model.nodes.size(), 30u);
  EXPECT_EQ(model.meshes.size(), 9u) << "12 triangles each";
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("those after it lack visuals: the scene has more than 100 triangles"),
            std::string::npos)
      << model.warnings[0];
}

TEST_F(Urdf, ErrorsNameFileAndLine) {
  EXPECT_NE(error_of("<robot name=\"a\">\n<link name=\"b\">\n</lnk>\n</robot>")
                .find("arm.urdf\", line 2: mismatched element"),
            std::string::npos);
  EXPECT_NE(error_of("<robot name=\"a\"></robot>").find("arm.urdf\": "), std::string::npos);
  const std::string two = link("x") + link("y") + joint("fixed", "x", "y") + joint("fixed", "y", "x");
  for (const std::string& more : {std::string(), link("root") + joint("fixed", "root", "x")}) {
    const std::string loop = error_of("<robot name=\"a\">" + two + more + "</robot>");
    EXPECT_NE(loop.find("link \"x\" hangs on itself"), std::string::npos) << loop;
  }
  EXPECT_NE(
      error_of("<robot name=\"a\">" + link("x") + joint("fixed", "x", "nobody") + "</robot>").find("nobody"),
      std::string::npos);
}

TEST_F(Urdf, LongChainDoesNotRecurse) {
  std::string inside = link("l0");
  for (int i = 1; i < 5000; ++i)
    inside +=
        link("l" + std::to_string(i)) + joint("fixed", "l" + std::to_string(i - 1), "l" + std::to_string(i));
  EXPECT_EQ(read(inside).nodes.size(), 5000u);
  std::string more;
  for (int i = 0; i < 20'001; ++i) more += "<link name=\"l\"/>";
  EXPECT_NE(error_of("<robot name=\"a\">" + more + "</robot>").find("more than 20000 links"),
            std::string::npos);
}

}  // namespace
}  // namespace fire3dv::convert
