// URDF: links as nodes under each other, joints at rest, what they show, and where their files are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/gltf_builder.h"
#include "tools/convert/readers.h"

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

const Node& node(const Model& model, const std::string& name) {
  for (const Node& each : model.nodes)
    if (each.name == name) return each;
  ADD_FAILURE() << "no node " << name;
  return model.nodes.front();
}

std::pair<glm::vec3, glm::vec3> bounds(const Mesh& mesh) {
  glm::vec3 low(1e9f), high(-1e9f);
  for (const Surface& surface : mesh.surfaces) {
    for (const glm::vec3& position : surface.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  }
  return {low, high};
}

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
    EXPECT_EQ(std::count(model.sources.begin(), model.sources.end(), path), 1) << path;
  }
}

TEST_F(Urdf, LinksStandUnderEachOtherWhereTheirJointsRest) {
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
  // 0 is out of both joints' range: they rest at 0.5.
  EXPECT_LT(glm::distance(node(model, "limited").rotation * glm::dvec3(1, 0, 0),
                          glm::dvec3(std::cos(0.5), std::sin(0.5), 0)),
            1e-9);
  EXPECT_LT(glm::distance(node(model, "pushed").translation, glm::dvec3(0.5, 0, 0)), 1e-9);
}

TEST_F(Urdf, ShapesHaveTheSizesThatUrdfMeans) {
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

TEST_F(Urdf, MaterialsAreFoundByNameAndColoursBecomeLight) {
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

TEST_F(Urdf, MeshesComeFromPackagesFromBesideTheFileAndFromFileUris) {
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
  ASSERT_EQ(model.meshes.size(), 5u);
  for (const Mesh& each : model.meshes)
    EXPECT_EQ(bounds(each), std::make_pair(glm::vec3(0, -2, 1), glm::vec3(1, 0, 2))) << each.name;
}

TEST_F(Urdf, WhatIsMissingIsNamedAndItsLinkIsKept) {
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
  EXPECT_NE(std::find(model.sources.begin(), model.sources.end(),
                      std::filesystem::canonical(folder_.path()) / "arm_description/urdf/gone.stl"),
            model.sources.end());
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

TEST_F(Urdf, WhatIsWrongIsToldWithFileAndLine) {
  EXPECT_NE(error_of("<robot name=\"a\">\n<link name=\"b\">\n</lnk>\n</robot>").find("arm.urdf\", line 3: "),
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

TEST_F(Urdf, AChainOfManyLinksIsNoChainOfCalls) {
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
