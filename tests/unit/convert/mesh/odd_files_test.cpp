// Test of mesh files that other programs read although they break the rules of their formats, and of concave
// polygons in all formats and descriptions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <tuple>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

double area(const Model& model) {
  double sum = 0;
  for (const Mesh& mesh : model.meshes) {
    for (const Surface& s : mesh.surfaces) {
      for (size_t i = 0; i + 2 < s.indices.size(); i += 3) {
        const glm::dvec3 a = s.positions[s.indices[i]], b = s.positions[s.indices[i + 1]],
                         c = s.positions[s.indices[i + 2]];
        sum += glm::length(glm::cross(b - a, c - a)) / 2;
      }
    }
  }
  return sum;
}

std::string all_warnings(const Model& model) {
  std::string text;
  for (const std::string& warning : model.warnings) text += warning + "\n";
  return text;
}

Result<Model> read_bytes(const test::ScratchFolder& folder, const std::string& name,
                         const std::string& bytes) {
  return read_description(folder.write(name, bytes), {});
}

void expect_area(const Result<Model>& model, double expected, const std::string& name,
                 const std::string& warning = "") {
  ASSERT_TRUE(model.ok()) << name << ": " << model.error().message;
  EXPECT_NEAR(area(*model), expected, 1e-5) << name;
  if (warning.empty())
    EXPECT_EQ(all_warnings(*model), "") << name;
  else
    EXPECT_NE(all_warnings(*model).find(warning), std::string::npos) << name << ": " << all_warnings(*model);
}

// A square with a square hole, joined by an edge that is doubled: area 8.
constexpr const char* kKeyhole[] = {"0 0 0", "3 0 0", "3 3 0", "0 3 0", "0 0 0",
                                    "1 1 0", "1 2 0", "2 2 0", "2 1 0", "1 1 0"};

std::string keyhole_obj() {
  std::string text, face = "f";
  for (size_t i = 0; i < std::size(kKeyhole); ++i) {
    text += "v " + std::string(kKeyhole[i]) + "\n";
    face += " " + std::to_string(i + 1);
  }
  return text + face + "\n";
}

std::string keyhole_ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const char* vertex : kKeyhole) text += std::string(vertex) + "\n";
  return text + "10 0 1 2 3 4 5 6 7 8 9\n";
}

std::string keyhole_dae() {
  std::string text = test::kDae, positions;
  for (const char* vertex : kKeyhole) positions += std::string(vertex) + " ";
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("<unit name=\"millimeter\" meter=\"0.001\"/>", "");
  replace("count=\"9\">0 0 0 1000 0 0 0 0 2000", "count=\"30\">" + positions);
  replace("count=\"3\" stride", "count=\"10\" stride");
  replace("<triangles count=\"1\"", "<polylist count=\"1\"");
  replace("<p>0 1 2</p></triangles>", "<vcount>10</vcount><p>0 1 2 3 4 5 6 7 8 9</p></polylist>");
  replace("0 3000", "0 3");
  return text;
}

TEST(OddFiles, ConcavePolygonsKeepTheirArea) {
  const test::ScratchFolder folder;
  expect_area(read_bytes(folder, "keyhole.obj", keyhole_obj()), 8, "OBJ");
  expect_area(read_bytes(folder, "keyhole.ply", keyhole_ply()), 8, "PLY");
  expect_area(read_bytes(folder, "keyhole.dae", keyhole_dae()), 8, "DAE");
  for (const char* mesh : {"keyhole.obj", "keyhole.ply", "keyhole.dae"}) {
    const std::string file(mesh);
    expect_area(read_bytes(folder, "robot.urdf",
                           "<robot name=\"r\"><link name=\"l\"><visual><geometry><mesh filename=\"" + file +
                               "\"/></geometry></visual></link></robot>"),
                8, "URDF " + file);
    const Result<Model> sdf = read_bytes(
        folder, "model.sdf",
        "<sdf version=\"1.6\"><model name=\"m\"><link name=\"l\"><visual name=\"v\"><geometry><mesh><uri>" +
            file + "</uri></mesh></geometry></visual></link></model></sdf>");
    if (sdf.ok() || sdf.error().message.find("libsdformat") == std::string::npos)
      expect_area(sdf, 8, "SDF " + file);
  }
  expect_area(
      read_bytes(folder, "model.xml",
                 "<mujoco><asset><mesh name=\"m\" file=\"keyhole.obj\" inertia=\"shell\"/></asset><worldbody>"
                 "<geom type=\"mesh\" mesh=\"m\"/></worldbody></mujoco>"),
      8, "MJCF");
}

TEST(OddFiles, CornersOfConcavePolygonsKeepTheirAttributes) {
  const test::ScratchFolder folder;
  // Texture coordinates and colours follow the position, also across the notch.
  const Result<Model> model =
      read_bytes(folder, "notch.obj",
                 "v 0 0 0 0 0 0\nv 2 0 0 1 0 0\nv 2 2 0 1 1 0\nv 1 0.5 0 0.5 0.25 0\nv 0 2 0 0 1 0\n"
                 "vt 0 0\nvt 1 0\nvt 1 1\nvt 0.5 0.25\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1 4/4/1 5/5/1\n");
  expect_area(model, 2.5, "notch");
  const Surface& s = model->meshes.at(0).surfaces.at(0);
  ASSERT_EQ(s.positions.size(), 5u);
  for (size_t i = 0; i < s.positions.size(); ++i) {
    EXPECT_FLOAT_EQ(s.uvs[i].x, s.positions[i].x / 2);
    EXPECT_FLOAT_EQ(1 - s.uvs[i].y, s.positions[i].y / 2);
    EXPECT_NEAR(s.colors[i].x, linear_from_srgb(glm::vec3(s.positions[i].x / 2)).x, 1e-5);
    EXPECT_EQ(s.normals[i], glm::vec3(0, 0, 1));
  }
  expect_area(read_bytes(folder, "bow.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n"), 1, "bow",
              "1 polygon crosses itself");
}

std::string text_stl(const std::string& solid, const std::string& facet) {
  return solid + facet +
         " normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
}

TEST(OddFiles, TextStlIsReadInAnyForm) {
  const test::ScratchFolder folder;
  const std::string plain = text_stl("solid a part\n", "facet") + "endsolid a part\n";
  std::string capitals = plain, lines = plain, one_line = plain, cut = plain;
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (size_t at = 0; (at = lines.find('\n', at)) != std::string::npos; at += 2) lines.replace(at, 1, "\r\n");
  std::replace(one_line.begin() + 13, one_line.end(), '\n', ' ');
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"plain", plain},
           {"capitals", capitals},
           {"line ends", lines},
           {"one line", one_line},
           {"blank lines", "\n \r\n\n" + plain},
           {"byte order mark", "\xEF\xBB\xBF" + plain},
           {"no name", text_stl("solid\n", "facet")},
           {"no solid", text_stl("", "facet")},
           {"comments", "# by hand\n" + text_stl("solid a # part\n# here\n", "facet")}})
    expect_area(read_bytes(folder, "text.stl", text), 1, name);
  EXPECT_EQ(read_bytes(folder, "text.stl", plain)->nodes.at(0).name, "a part");
  cut.resize(cut.find("vertex 0 1"));
  expect_area(read_bytes(folder, "text.stl", plain + cut), 1, "cut short", "1 facet without three vertices");
  std::string two = plain + plain;
  two.replace(two.rfind("2 0 0"), 5, ".5 0 0");
  const Result<Model> solids = read_bytes(folder, "text.stl", two);
  expect_area(solids, 1.25, "two solids");
  EXPECT_EQ(solids->nodes.size(), 2u);
  std::string comma = plain;
  comma.replace(comma.find("2 0 0"), 1, "2,5");
  const Result<Model> refused = read_bytes(folder, "comma.stl", comma);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("line 5: \"2,5\" has a decimal comma"), std::string::npos)
      << refused.error().message;
}

std::string counted_stl(uint32_t count, const std::string& header, const std::string& behind) {
  std::string bytes = test::binary_stl();
  bytes.replace(0, header.size(), header);
  bytes.replace(80, 4, test::raw(count));
  return bytes + bytes.substr(84) + behind;
}

TEST(OddFiles, TruncatedBinaryStlKeepsWholeTriangles) {
  const test::ScratchFolder folder;
  for (const std::string header : {"robot", "solid part", "SOLID facet normal endsolid"}) {
    expect_area(read_bytes(folder, "b.stl", counted_stl(2, header, "")), 1, "exact");
    expect_area(read_bytes(folder, "b.stl", counted_stl(2, header, "\n")), 1, "trailing",
                "1 byte behind its triangles");
    expect_area(read_bytes(folder, "b.stl", counted_stl(2, header, std::string(7, '\0'))), 1, "trailing",
                "7 bytes");
    expect_area(read_bytes(folder, "b.stl", counted_stl(1, header, "")), 0.5, "fewer",
                "50 bytes behind its triangles");
    expect_area(read_bytes(folder, "b.stl", counted_stl(0, header, "")), 1, "none",
                "counts 0 triangles, but there are 2");
    expect_area(read_bytes(folder, "b.stl", counted_stl(99, header, "")), 1, "more",
                "there are 2; is it cut short?");
  }
  std::string damaged = counted_stl(2, "robot", "");
  damaged.replace(84 + 12, 4, test::raw(std::nanf("")));
  expect_area(read_bytes(folder, "b.stl", damaged), 0.5, "not finite",
              "1 facet left out (first is facet 1): a vertex is not finite");
  EXPECT_FALSE(read_bytes(folder, "b.stl", std::string(400, 'x')).ok());
  EXPECT_FALSE(read_bytes(folder, "b.stl", std::string(400, '\xee')).ok());
  folder.write("b.stl", counted_stl(9, "robot", "abc"));
  expect_area(
      read_bytes(folder, "r.urdf",
                 "<robot name=\"r\"><link name=\"l\"><visual><geometry><mesh filename=\"b.stl\"/></geometry>"
                 "</visual></link></robot>"),
      1, "URDF", "counts 9 triangles");
}

TEST(OddFiles, ColoursOfStlFacets) {
  const test::ScratchFolder folder;
  const auto colors = [&](const std::string& header, uint16_t first, uint16_t second) {
    std::string bytes = counted_stl(2, header, "");
    bytes.replace(84 + 48, 2, test::raw(first));
    bytes.replace(84 + 98, 2, test::raw(second));
    bytes[84 + 50 + 12] = 1;  // another vertex
    const Result<Model> model = read_bytes(folder, "c.stl", bytes);
    std::set<std::tuple<int, int, int>> found;
    if (!model.ok()) return found;
    for (const glm::vec4& c : model->meshes.at(0).surfaces.at(0).colors)
      found.insert({std::lround(c.r), std::lround(c.g), std::lround(c.b)});
    return found;
  };
  using Colors = std::set<std::tuple<int, int, int>>;
  EXPECT_EQ(colors("part", 0, 0), Colors());
  EXPECT_EQ(colors("part", 0x8000 | 31, 0x8000 | 31 << 10), (Colors{{0, 0, 1}, {1, 0, 0}})) << "VisCAM";
  const std::string magics("COLOR=\x00\xff\x00\xff", 10);
  EXPECT_EQ(colors(magics, 0, 0), (Colors{{0, 1, 0}}));
  EXPECT_EQ(colors(magics, 31, 0x8000), (Colors{{1, 0, 0}, {0, 1, 0}})) << "the mark means none";
  EXPECT_EQ(colors(magics, 0x8000 | 31, 0x8000 | 31 << 10), (Colors{{1, 0, 0}, {0, 0, 1}})) << "MeshLab";
}

std::string utf16(const std::string& text, bool big, bool mark) {
  std::string bytes = mark ? (big ? "\xFE\xFF" : "\xFF\xFE") : "";
  for (const char c : text) {
    if (big) bytes += '\0';
    bytes += c;
    if (!big) bytes += '\0';
  }
  return bytes;
}

TEST(OddFiles, ObjNumbersAreReadOrNamed) {
  const test::ScratchFolder folder;
  const auto obj = [&](const std::string& first, const std::string& rest = "f 1 2 3\n") {
    return read_bytes(folder, "n.obj", "v " + first + "\nv 2 0 0\nv 0 1 0\n" + rest);
  };
  expect_area(obj("0 0 0"), 1, "plain");
  expect_area(obj("+.0 -.0 .0"), 1, "points first");
  expect_area(obj("-.5 .5 0"), 1.25 - 0.5, "points first");
  expect_area(obj("-2. 0. 0E+0"), 2, "points last");
  expect_area(obj("-2d0 0 0"), 2, "Fortran");
  expect_area(obj("0 0 0 1"), 1, "weight");
  expect_area(obj("0 0 0 0"), 1, "weight of 0");
  expect_area(obj("-2 0 0 0.5"), 2, "weight of a curve");
  expect_area(obj("0 0 1e-400"), 1, "too small");
  expect_area(obj("0 0 0", "vt .5 .25\nvt 1 .5\nvt .25 1\nf 1/1 2/2 3/3 # a face\n"), 1, "vt");
  EXPECT_EQ(obj("0 0 0", "vt .5 .25\nvt 1 .5\nvt .25 1\nf 1/1 2/2 3/3\n")->meshes[0].surfaces[0].uvs[0],
            glm::vec2(0.5f, 0.75f));
  expect_area(obj("0 0 0", "f 1 2 \\\n 3\n"), 1, "continued line");
  expect_area(obj("0 0 0", "f -3 -2 -1\nv 9 9 9\n"), 1, "relative");
  expect_area(obj("0 0 0", "f 1/1/1 2/1/1 3/1/1\n"), 1, "missing", "texture coordinates that are missing");
  expect_area(obj("0 0 0", "vt 0 0\nf 1/1 2 3/1\n"), 1, "mixed", "first in line 5");
  expect_area(obj("0 0 0", "vn nan 0 0\nf 1//1 2//1 3//1\n"), 1, "normal", "\"nan\" is not finite");
  expect_area(obj("0 0 0", "v 1.#IND 0 0\nf 1 2 3\n"), 1, "a damaged vertex that no face names");
  expect_area(obj("nan 0 0", "v 0 0 0\nf 1 2 3\nf 4 2 3\n"), 1, "a damaged vertex",
              "1 face with damaged vertices: left out (1 time, first in line 1: \"nan\" is not finite)");
  expect_area(obj("0 0"), 1, "two numbers", "the third is 0");
  expect_area(obj("0 0 0 nan 1 1"), 1, "colour", "colours of vertices are damaged");
  const auto refusal = [&](const Result<Model>& model) {
    return model.ok() ? std::string("read") : model.error().message;
  };
  for (const auto& [first, reason] :
       std::vector<std::pair<std::string, std::string>>{{"0,5 0 0", "line 1: \"0,5\" has a decimal comma"},
                                                        {"1.#IND 0 0", "\"1.#IND\" is not finite"},
                                                        {"-nan(ind) 0 0", "\"-nan(ind)\" is not finite"},
                                                        {"1e400 0 0", "\"1e400\" is not finite"},
                                                        {"0", "fewer than three numbers"}})
    EXPECT_NE(refusal(obj(first)).find(reason), std::string::npos) << refusal(obj(first));
  EXPECT_NE(refusal(obj("0 0 0", "f 1 2 4\n")).find("line 4: a face names vertex 4, but there are 3"),
            std::string::npos)
      << refusal(obj("0 0 0", "f 1 2 4\n"));
  EXPECT_NE(refusal(obj("0 0 0", "f 1 2 x\n")).find("line 4: a face names a vertex by \"x\""),
            std::string::npos);
}

TEST(OddFiles, TextOf16BitsIsRead) {
  const test::ScratchFolder folder;
  std::string obj = "mtllib colours.mtl\no a part\nv 0 0 0\nv 2 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
  for (const bool big : {false, true}) {
    for (const bool mark : {false, true}) {
      folder.write("colours.mtl", utf16("newmtl red\nKd 1 0 0\n", big, mark));
      const Result<Model> model = read_bytes(folder, "u.obj", utf16(obj, big, mark));
      expect_area(model, 1, "OBJ");
      EXPECT_EQ(model->nodes.at(0).name, "a part");
      EXPECT_EQ(model->materials.at(0).base_color, glm::vec4(1, 0, 0, 1));
      std::string dae = keyhole_dae();
      dae.replace(dae.find("utf-8"), 5, "utf-16");
      expect_area(read_bytes(folder, "u.dae", utf16(dae, big, mark)), 8, "DAE");
    }
  }
}

std::string ply(const std::string& vertex, const std::string& elements, const std::string& data) {
  return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
         vertex + elements + "end_header\n" + data;
}

constexpr const char* kSquare = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

std::set<std::tuple<float, float, float, float>> colors_of(const Model& model) {
  std::set<std::tuple<float, float, float, float>> found;
  for (const glm::vec4& c : model.meshes.at(0).surfaces.at(0).colors) found.insert({c.r, c.g, c.b, c.a});
  return found;
}

TEST(OddFiles, ColoursOfPlyFaces) {
  const test::ScratchFolder folder;
  using Colors = std::set<std::tuple<float, float, float, float>>;
  const std::string rgb = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string list = "property list uchar int vertex_indices\n";
  const Colors red_and_blue = {{1, 0, 0, 1}, {0, 0, 1, 1}};
  const auto read_ply = [&](const std::string& text) {
    Result<Model> model = read_bytes(folder, "c.ply", text);
    EXPECT_TRUE(model.ok()) << text << model.error().message;
    if (!model.ok()) return Colors();
    EXPECT_NEAR(area(*model), 1, 1e-6) << text;
    return colors_of(*model);
  };
  EXPECT_EQ(read_ply(ply("", "element face 2\n" + list + rgb,
                         std::string(kSquare) + "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n")),
            red_and_blue);
  EXPECT_EQ(read_ply(ply("", "element face 2\n" + rgb + "property uchar alpha\n" + list,
                         std::string(kSquare) + "255 0 0 255 3 0 1 2\n0 0 255 0 3 0 2 3\n")),
            (Colors{{1, 0, 0, 1}, {0, 0, 1, 0}}));
  EXPECT_EQ(
      read_ply(ply(
          "",
          "element face 2\nproperty float r\nproperty float g\nproperty float b\nproperty float a\n" + list,
          std::string(kSquare) + "1 0 0 0 3 0 1 2\n0 0 1 0 3 0 2 3\n")),
      red_and_blue)
      << "an opacity of 0 everywhere means none";
  EXPECT_EQ(read_ply(ply("property uchar r\nproperty uchar g\nproperty uchar b\n", "element face 1\n" + list,
                         "0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 0 0 255\n0 1 0 0 0 255\n4 0 1 2 3\n")),
            red_and_blue);
  EXPECT_EQ(read_ply(ply(rgb, "element face 1\n" + list + "property uchar red\n",
                         "0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 0 0 255\n0 1 0 0 0 255\n4 0 1 2 3 7\n")),
            red_and_blue)
      << "colours of vertices win";
}

TEST(OddFiles, PlyTextSkipsCommentsAndSurplusNumbers) {
  const test::ScratchFolder folder;
  const std::string list = "element face 2\nproperty list uchar int vertex_indices\n";
  expect_area(read_bytes(folder, "c.ply",
                         ply("", list,
                             "comment a\n\n0 0 0\n1 0 0 7\ncomment b\n1 1 0\n0 1 0\n3 0 1 2 3 9 9 9\n"
                             "3 0 2 3 3 9 9 9\n")),
              1, "lines");
  expect_area(read_bytes(folder, "c.ply", ply("", list, "0 0 0 1 0 0 1\n1 0 0 1 0 3 0 1 2\n3 0\n2 3\n")), 1,
              "numbers without lines");
}

TEST(OddFiles, PlyStripsAndTextureCoordinatesOfFaces) {
  const test::ScratchFolder folder;
  const std::string strips = "element tristrips 1\nproperty list int int vertex_indices\n";
  const Result<Model> strip =
      read_bytes(folder, "s.ply", ply("", strips, std::string(kSquare) + "10 0 1 3 2 -1 0 1 2 2 2\n"));
  expect_area(strip, 1.5, "strips");
  for (const Surface& s : strip->meshes.at(0).surfaces)
    for (size_t i = 0; i < s.indices.size(); i += 3) {
      const glm::vec3 a = s.positions[s.indices[i]], b = s.positions[s.indices[i + 1]],
                      c = s.positions[s.indices[i + 2]];
      EXPECT_GT(glm::cross(b - a, c - a).z, 0) << "each second triangle of a strip is turned";
    }
  std::string binary = ply("", strips, "");
  binary.replace(binary.find("ascii"), 5, "binary_big_endian");
  const auto number = [](auto value) {
    std::string bytes = test::raw(value);
    std::reverse(bytes.begin(), bytes.end());
    return bytes;
  };
  for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f}) binary += number(f);
  for (const int32_t i : {9, 0, 1, 3, 2, -1, 0, 1, 2, -1}) binary += number(i);
  expect_area(read_bytes(folder, "b.ply", binary), 1.5, "binary strips");
  EXPECT_FALSE(read_bytes(folder, "w.ply", ply("", strips, std::string(kSquare) + "3 0 1 4\n")).ok());

  const Result<Model> model = read_bytes(
      folder, "t.ply",
      ply("", "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n",
          std::string(kSquare) + "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n"));
  expect_area(model, 1, "texture coordinates of faces");
  const Surface& s = model->meshes.at(0).surfaces.at(0);
  ASSERT_EQ(s.uvs.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(s.uvs[i], glm::vec2(s.positions[i].x, 1 - s.positions[i].y));
}

}  // namespace
}  // namespace fire3dv::convert
