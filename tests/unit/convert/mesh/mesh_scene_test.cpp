// Test of mesh files as scenes: a unit cube in every format gives the same vertices, colour and outside;
// units, axes, names, images and hostile files.
#include "convert/readers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

using Point = std::tuple<float, float, float>;

// Corner i of the cube from 0 to 1: its bits are x, y and z. Faces are counter-clockwise seen from outside.
constexpr int kFaces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

std::string corner(int i) {
  return std::to_string(i & 1) + " " + std::to_string(i >> 1 & 1) + " " + std::to_string(i >> 2 & 1);
}

std::string obj_cube() {
  std::string text = "mtllib cube.mtl\no the cube\n";
  for (int i = 0; i < 8; ++i) text += "v " + corner(i) + "\n";
  text += "usemtl orange paint\n";
  for (const auto& f : kFaces)
    text += "f " + std::to_string(f[0] + 1) + " " + std::to_string(f[1] + 1) + " " +
            std::to_string(f[2] + 1) + "\n";
  return text;
}

std::string ascii_stl_cube() {
  std::string text = "solid the cube\n";
  for (const auto& f : kFaces) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int i : f) text += "vertex " + corner(i) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid the cube\n";
}

// color: RGB of 5 bits each, as VisCAM writes it (blue in the low bits).
std::string binary_stl_cube(uint16_t color) {
  std::string bytes(80, ' ');
  bytes += test::raw<uint32_t>(12);
  for (const auto& f : kFaces) {
    for (int i = 0; i < 3; ++i) bytes += test::raw(0.0f);
    for (const int at : f)
      for (int axis = 0; axis < 3; ++axis) bytes += test::raw(static_cast<float>(at >> axis & 1));
    bytes += test::raw<uint16_t>(static_cast<uint16_t>(0x8000 | color));
  }
  return bytes;
}

std::string ply_cube(const std::string& color) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
      "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) text += corner(i) + " " + color + "\n";
  for (const auto& f : kFaces)
    text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
  return text;
}

// In centimetres, below a node that scales by 50 and one by 2, with +Y up.
std::string dae_cube() {
  std::string positions, indices;
  for (int i = 0; i < 8; ++i) positions += corner(i) + " ";
  for (const auto& f : kFaces)
    for (const int i : f) indices += std::to_string(i) + " ";
  std::string text = test::kDae;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("<unit name=\"millimeter\" meter=\"0.001\"/><up_axis>Z_UP",
          "<unit name=\"centimeter\" meter=\"0.01\"/><up_axis>Y_UP");
  replace("count=\"9\">0 0 0 1000 0 0 0 0 2000", "count=\"24\">" + positions);
  replace("count=\"3\" stride", "count=\"8\" stride");
  replace("<triangles count=\"1\"", "<triangles count=\"12\"");
  replace("<p>0 1 2</p>", "<p>" + indices + "</p>");
  replace("<color>0.5 0.25 0 1</color>", "<color>1 0.5 0 1</color>");
  replace("name=\"m\">", "name=\"orange paint\">");
  replace("<node id=\"n\"><matrix>-1 0 0 0  0 1 0 3000  0 0 1 0  0 0 0 1</matrix>",
          "<node id=\"a\" name=\"holder\"><scale>50 50 50</scale><node id=\"n\" name=\"the cube\"><scale>2 2 "
          "2</scale>");
  replace("</instance_geometry></node>", "</instance_geometry></node></node>");
  return text;
}

struct Cube {
  std::multiset<Point> corners;  // of all triangles, in glTF's frame
  std::set<std::string> names;   // of nodes with a mesh
  glm::vec4 color{0};            // base colour times vertex colour; all vertices have the same
  bool is_outside = true;        // all triangles are counter-clockwise seen from outside
  std::string material;
};

float rounded(double x) {
  return static_cast<float>(std::round(x * 1e4) * 1e-4) + 0.0f;
}

Cube flattened(const Model& model) {
  Cube cube;
  std::vector<glm::dmat4> gltf_from_node;
  bool has_color = false;
  glm::dvec3 centre(0);
  std::vector<std::array<glm::dvec3, 3>> triangles;
  for (const Node& node : model.nodes) {
    EXPECT_EQ(node.scale, glm::dvec3(1)) << "scales belong to vertices: " << node.name;
    glm::dmat4 local = glm::mat4_cast(node.rotation);
    local[3] = glm::dvec4(node.translation, 1);
    gltf_from_node.push_back(
        (node.parent ? gltf_from_node[*node.parent] : glm::mat4_cast(model.gltf_from_model)) * local);
    if (!node.mesh) continue;
    cube.names.insert(node.name);
    for (const Surface& s : model.meshes[*node.mesh].surfaces) {
      for (size_t i = 0; i < s.indices.size(); ++i) {
        const glm::dvec3 p = gltf_from_node.back() * glm::dvec4(glm::dvec3(s.positions[s.indices[i]]), 1);
        if (i % 3 == 0) triangles.emplace_back();
        triangles.back()[i % 3] = p;
        centre += p;
        cube.corners.insert({rounded(p.x), rounded(p.y), rounded(p.z)});
        const glm::vec4 color = model.materials[s.material].base_color *
                                (s.colors.empty() ? glm::vec4(1) : s.colors[s.indices[i]]);
        EXPECT_TRUE(!has_color || glm::length(color - cube.color) < 1e-5f);
        cube.color = color;
        has_color = true;
      }
      cube.material = model.materials[s.material].name;
    }
  }
  centre /= std::max<double>(1, static_cast<double>(3 * triangles.size()));
  for (const auto& t : triangles)
    cube.is_outside &= glm::dot(glm::cross(t[1] - t[0], t[2] - t[0]), t[0] - centre) > 0;
  return cube;
}

// The cube's corners after the mapping of file axes to glTF's.
std::multiset<Point> expected(bool y_up, double side = 1) {
  std::multiset<Point> corners;
  for (const auto& f : kFaces) {
    for (const int i : f) {
      const double x = side * (i & 1), y = side * (i >> 1 & 1), z = side * (i >> 2 & 1);
      corners.insert(y_up ? Point(rounded(x), rounded(y), rounded(z))
                          : Point(rounded(x), rounded(z), rounded(-y)));
    }
  }
  return corners;
}

Model read(const std::filesystem::path& file, const ReadOptions& options = {}) {
  Result<Model> model = read_description(file, options);
  EXPECT_TRUE(model.ok()) << file << ": " << (model ? "" : model.error().message);
  return model ? std::move(*model) : Model();
}

const glm::vec4 kOrange(1, 0.21404114f, 0, 1);  // sRGB 1, 0.5, 0 in linear light

TEST(MeshScene, FormatsAgreeOnACube) {
  const test::ScratchFolder folder;
  folder.write("cube.mtl", "newmtl orange paint\nKd 1 0.5 0\n");
  struct Case {
    std::string file, bytes, name;
    bool y_up;
    glm::vec4 color;
  };
  const glm::vec4 plain(glm::vec3(linear_from_srgb(glm::vec3(0.7f))), 1);
  const float fifteen = linear_from_srgb(glm::vec3(15.0f / 31)).x;
  const float byte = linear_from_srgb(glm::vec3(128.0f / 255)).x;
  for (const Case& c :
       std::vector<Case>{{"c.obj", obj_cube(), "the cube", true, kOrange},
                         {"c.stl", ascii_stl_cube(), "the cube", false, plain},
                         {"b.STL", binary_stl_cube(31 << 10 | 15 << 5), "b", false, {1, fifteen, 0, 1}},
                         {"c.ply", ply_cube("255 128 0 255"), "c", false, {1, byte, 0, 1}},
                         {"clear.ply", ply_cube("255 128 0 0"), "clear", false, {1, byte, 0, 1}},
                         {"c.dae", dae_cube(), "the cube", true, kOrange}}) {
    const Model model = read(folder.write(c.file, c.bytes));
    const Cube cube = flattened(model);
    EXPECT_EQ(cube.corners, expected(c.y_up)) << c.file;
    EXPECT_EQ(cube.names, std::set<std::string>{c.name}) << c.file;
    EXPECT_LT(glm::length(cube.color - c.color), 1e-4f) << c.file << ' ' << cube.color.g;
    EXPECT_TRUE(cube.is_outside) << c.file;
    EXPECT_TRUE(model.warnings.empty()) << c.file << ": " << model.warnings[0];
    EXPECT_TRUE(model.lights.empty()) << "the renderer lights a part";
    if (c.y_up) {
      EXPECT_EQ(cube.material, "orange paint") << c.file;
    }
    EXPECT_TRUE(write_glb(model).ok()) << c.file;
    // A cube's edges are sharp: each computed normal is that of a face.
    for (const Mesh& mesh : model.meshes)
      for (const Surface& s : mesh.surfaces)
        for (const glm::vec3& n : s.normals)
          EXPECT_NEAR(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1, 1e-5) << c.file;
  }
}

TEST(MeshScene, UnitAndAxesAreOptions) {
  const test::ScratchFolder folder;
  const auto file = folder.write("c.stl", ascii_stl_cube());
  ReadOptions options;
  options.mesh_up = MeshUp::y;
  EXPECT_EQ(flattened(read(file, options)).corners, expected(true));
  options.mesh_unit_m = 0.0254;
  EXPECT_EQ(flattened(read(file, options)).corners, expected(true, 0.0254));
  const auto refusal = [&](const std::filesystem::path& scene) {
    const Result<Model> model = read_description(scene, options);
    return model ? std::string("read") : model.error().message;
  };
  EXPECT_NE(refusal(folder.write("c.dae", dae_cube())).find("its own unit and axes"), std::string::npos);
  EXPECT_NE(refusal(folder.write("a.urdf", "<robot name=\"r\"/>")).find("remove --up"), std::string::npos);
}

TEST(MeshScene, TreeHasNoScales) {
  const test::ScratchFolder folder;
  const Model model = read(folder.write("c.dae", dae_cube()));
  ASSERT_EQ(model.nodes.size(), 2u);
  EXPECT_EQ(model.nodes[0].name, "holder");
  EXPECT_EQ(model.nodes[1].name, "the cube");
  EXPECT_EQ(model.nodes[1].parent, std::optional<size_t>(0));
  EXPECT_EQ(model.name, "c");
}

TEST(MeshScene, OmissionsAreReported) {
  const test::ScratchFolder folder;
  std::string text = dae_cube();
  const std::string light =
      "<library_lights><light id=\"l\"><technique_common><point><color>1 1 1</color></point>"
      "</technique_common></light></library_lights>";
  text.insert(text.find("<library_visual_scenes>"), light);
  text.insert(text.find("<instance_geometry"), "<instance_light url=\"#l\"/>");
  const Model model = read(folder.write("c.dae", text));
  ASSERT_EQ(model.warnings.size(), 1u);
  EXPECT_NE(model.warnings[0].find("its lights are left out"), std::string::npos) << model.warnings[0];
}

TEST(MeshScene, MtlPropertiesAreKept) {
  const test::ScratchFolder folder;
  const std::vector<uint8_t> grey = {64, 64, 64};
  const auto png = png_of(grey, 1, 1, 3);
  ASSERT_TRUE(png.ok());
  for (const char* name : {"base.png", "glow.png", "rough.png", "metal.png", "bumps.png"})
    folder.write(name, std::span(*png));
  folder.write("cube.mtl",
               "newmtl orange paint\nKd 1 1 1\nmap_Kd base.png\nKe 0 0 0\nmap_Ke glow.png\nPr 0.5\nPm 0.25\n"
               "map_Pr rough.png\nmap_Pm metal.png\nnorm bumps.png\n");
  std::string text = obj_cube();
  const size_t at = text.find("usemtl");
  text.insert(at, "vt 0 0\n");
  const Model model = read(folder.write("c.obj", text));
  ASSERT_EQ(model.materials.size(), 1u);
  const Material& m = model.materials[0];
  EXPECT_EQ(m.roughness, 0.5f);
  EXPECT_EQ(m.metallic, 0.25f);
  EXPECT_EQ(m.emission, glm::vec3(1)) << "black beside a map is meant to be replaced";
  ASSERT_TRUE(m.base_color_image && m.emission_image && m.normal_image && m.metallic_roughness_image);
  EXPECT_EQ(model.images[*m.base_color_image].bytes, *png) << "images are kept as they are";
  // Roughness is green and metalness blue, as in glTF.
  const std::vector<uint8_t> packed = {255, 64, 64};
  EXPECT_EQ(model.images[*m.metallic_roughness_image].bytes, *png_of(packed, 1, 1, 3));

  folder.write("cube.mtl", "newmtl orange paint\nPm 0\nmap_Pm gone.png\n");
  const Model without = read(folder.write("d.obj", text));
  EXPECT_EQ(without.materials[0].metallic, 0) << "a metal without its map would be a mirror";
  ASSERT_EQ(without.warnings.size(), 1u);
  EXPECT_NE(without.warnings[0].find("gone.png"), std::string::npos);
}

TEST(MeshScene, MapDBecomesTheOpacityOfTheColour) {
  const test::ScratchFolder folder;
  const std::vector<uint8_t> red_blue = {200, 0, 0, 0, 0, 100}, grey = {64, 64, 64};
  folder.write("color.png", std::span(*png_of(red_blue, 2, 1, 3)));
  folder.write("mask.png", std::span(*png_of(grey, 1, 1, 3)));
  const std::vector<uint8_t> clear = {9, 8, 7, 32, 9, 8, 7, 255};
  folder.write("clear.png", std::span(*png_of(clear, 1, 2, 4)));
  const std::string text = obj_cube();
  const auto image = [&](const std::string& mtl) {
    folder.write("cube.mtl", "newmtl orange paint\n" + mtl);
    const Model model = read(folder.write("c.obj", text));
    const std::optional<size_t> index = model.materials.at(0).base_color_image;
    return index ? model.images[*index].bytes : std::vector<std::byte>();
  };
  // The mask is stretched to the larger image.
  const std::vector<uint8_t> masked = {200, 0, 0, 64, 0, 0, 100, 64};
  EXPECT_EQ(image("map_Kd color.png\nmap_d mask.png\n"), *png_of(masked, 2, 1, 4));
  // An image with an opacity is a mask by it, not by its brightness; a named channel wins.
  const std::vector<uint8_t> by_opacity = {200, 0, 0, 32, 0, 0, 100, 32, 200, 0, 0, 255, 0, 0, 100, 255};
  EXPECT_EQ(image("map_Kd color.png\nmap_d clear.png\n"), *png_of(by_opacity, 2, 2, 4));
  const std::vector<uint8_t> by_red = {255, 255, 255, 9, 255, 255, 255, 9};
  EXPECT_EQ(image("map_d -imfchan r clear.png\n"), *png_of(by_red, 1, 2, 4));
}

TEST(MeshScene, SmoothSurfacesGetSmoothNormals) {
  const test::ScratchFolder folder;
  // Two faces at an angle of 20 degrees share an edge, once with different texture coordinates there.
  const float tilt = std::sin(20 * 3.14159265f / 180), level = std::cos(20 * 3.14159265f / 180);
  const std::string text = "v 0 0 0\nv 0 1 0\nv -1 0 0\nv " + std::to_string(level) + " 0 " +
                           std::to_string(-tilt) + "\nvt 0 0\nvt 1 0\nf 1/1 2/1 3/1\nf 1/2 4/2 2/2\n";
  const Model model = read(folder.write("roof.obj", text));
  ASSERT_EQ(model.meshes.size(), 1u);
  const Surface& s = model.meshes[0].surfaces.at(0);
  ASSERT_EQ(s.normals.size(), 6u) << "texture coordinates keep the edge's vertices apart";
  for (size_t v = 0; v < s.positions.size(); ++v) {
    if (s.positions[v] != glm::vec3(0) && s.positions[v] != glm::vec3(0, 1, 0)) continue;
    EXPECT_NEAR(s.normals[v].x, std::sin(10 * 3.14159265 / 180), 1e-4) << v;  // halfway
  }
}

TEST(MeshScene, RefusalsNameFileAndReason) {
  const test::ScratchFolder folder;
  struct Case {
    std::string file, bytes, reason;
  };
  std::string nan_stl = binary_stl_cube(0);
  const std::string nan = test::raw(std::nanf(""));
  for (size_t i = 0; i < 12; ++i) nan_stl.replace(84 + 50 * i + 12, 4, nan);
  // Neither the count nor the coordinates are those of an STL file.
  std::string many_stl = binary_stl_cube(0);
  many_stl.replace(80, 4, test::raw<uint32_t>(0xffffffff));
  const std::string far = test::raw(1e30f);
  many_stl.replace(84 + 12, 4, far);
  std::string many_ply = ply_cube("0 0 0 0");
  many_ply.replace(many_ply.find("vertex 8"), 8, "vertex 4000000000000000000");
  std::string wrong_ply = ply_cube("0 0 0 0");
  wrong_ply.replace(wrong_ply.rfind("5\n"), 1, "8");
  std::string wrong_obj = obj_cube() + "f 1 2 99\n";
  for (const Case& c : std::vector<Case>{
           {"a.stl", "\x89PNG\r\n", "is a PNG image"},
           {"a.obj", "glTF\2", "is glTF already"},
           {"a.ply", "PK\x03\x04", "ZIP archive"},
           {"a.obj", "", "an empty file: write it again"},
           {"b.obj", "hello\n", "it is damaged, or not what its name says ("},
           {"text.stl", "hello there\n", "it is damaged, or not what its name says ("},
           {"a.dae", "<?xml version=\"1.0\"?>\n<robot name=\"r\"/>", "URDF"},
           {"cut.dae", dae_cube().substr(0, 700), "cut.dae"},
           {"nan.stl", nan_stl, "not finite"},
           {"many.stl", many_stl, "its count of triangles is wrong"},
           {"cut.stl", binary_stl_cube(0).substr(0, 100), "there is no triangle"},
           {"many.ply", many_ply, "cut short"},
           {"cut.ply", ply_cube("0 0 0 0").substr(0, 400), "cut short"},
           {"index.ply", wrong_ply, "a vertex that it does not have"},
           {"index.obj", wrong_obj, "index.obj"},
           {"points.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            "point clouds"}}) {
    const Result<Model> model = read_description(folder.write(c.file, c.bytes), {});
    ASSERT_FALSE(model.ok()) << c.file;
    const std::string& message = model.error().message;
    EXPECT_NE(message.find(c.reason), std::string::npos) << message;
    EXPECT_NE(message.find(c.file), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_FALSE(read_description(folder.path() / "gone.obj", {}).ok());
  EXPECT_FALSE(read_description("/dev/zero", {}).ok());
}

// Truncated at any position, and with changed bytes: read or refused, and a read scene can be written.
TEST(MeshScene, DamagedFilesHarmNobody) {
  const test::ScratchFolder folder;
  folder.write("cube.mtl", "newmtl orange paint\nKd 1 0.5 0\n");
  const std::pair<const char*, std::string> seeds[] = {{"a.obj", obj_cube()},
                                                       {"b.stl", binary_stl_cube(7)},
                                                       {"a.ply", ply_cube("1 2 3 4")},
                                                       {"a.dae", dae_cube()}};
  uint32_t random = 7;
  const auto next = [&] { return (random = random * 1664525 + 1013904223) >> 8; };
  size_t refused = 0, read = 0;
  for (const auto& [name, seed] : seeds) {
    for (size_t i = 0; i < 12; ++i) {
      std::string damaged = seed.substr(0, i % 2 == 0 ? seed.size() * i / 12 : seed.size());
      if (i % 2 == 1)
        for (size_t k = 0; k < 1 + i / 2; ++k) damaged[next() % damaged.size()] = static_cast<char>(next());
      const Result<Model> model = read_description(folder.write(std::to_string(i) + name, damaged), {});
      if (!model) {
        ++refused;
        EXPECT_EQ(model.error().message.find('\n'), std::string::npos);
        continue;
      }
      ++read;
      EXPECT_TRUE(write_glb(*model).ok());
    }
  }
  EXPECT_GT(refused, 8u);
  EXPECT_GT(read, 5u);
}

}  // namespace
}  // namespace fire3dv::convert
