// Test of MJCF assets: mesh formats, hulls, normals, height fields and textures, with malformed data.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <string_view>

#include "convert/mjcf/assets/convex_hull.h"
#include "convert/mjcf/assets/mesh_data.h"
#include "convert/mjcf/assets/png_pixels.h"
#include "convert/mjcf/assets/texture_pattern.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"
#include "tests/unit/convert/mjcf/mjcf_fixture.h"
#include "tests/unit/renderer/scene/gltf/model_accessors.h"

namespace fire3dv::convert {
namespace {

std::string words(std::initializer_list<uint32_t> values) {
  std::string text;
  for (const uint32_t value : values) text += test::raw(value);
  return text;
}

const uint32_t kOne = std::bit_cast<uint32_t>(1.0f), kNan = 0x7fc00000;

template <typename Parsed>
std::string reason(const Result<Parsed>& result) {
  return result.ok() ? "none" : result.error().message;
}

TEST(MjcfMeshFormats, ObjFaceFormsAreRead) {
  const std::string corners = "v 0 0 0\nv +1 0 0 0.5 0.5 0.5\nv 0 1 0\r\nv 0 0 1e-50\n";
  const Result<MeshData> mesh = parse_obj("# comment\nmtllib none.mtl\n" + corners +
                                          "f 1 2 3\n f\t-4 -3 -2 -1\nl 1 2\nf 1 2 5\nv 2 2 2\n");
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  ASSERT_EQ(mesh->faces.size(), 4u);  // a triangle, a quad, and a face before its vertex
  EXPECT_EQ(mesh->faces[2], (MeshData::Triangle{0, 2, 3}));
  EXPECT_EQ(mesh->faces[3], (MeshData::Triangle{0, 1, 4}));
  EXPECT_TRUE(mesh->uv_faces.empty() && mesh->normal_faces.empty());
  const Result<MeshData> whole = parse_obj(corners + "vt .25 .75\nvn 0 0 1\nf 1/1/1 2/1/1 3/-1/-1\n");
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  EXPECT_EQ(whole->uvs[0], glm::vec2(0.25f, 0.25f)) << "from the upper edge";
  EXPECT_EQ(whole->normal_faces.size(), 1u);
  EXPECT_TRUE(parse_obj(corners + "vt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\n")->uv_faces.empty())
      << "not for all corners";
  const struct {
    const char *line, *part;
  } faults[] = {{"f 1 2 6\n", "vertex 5 of 4"},
                {"f 1 2 99999999999999999999\n", "something else than a number"},
                {"f 0 1 2\n", "something else than a number"},
                {"f -5 1 2\n", "vertex -5, which does not exist"},
                {"f 1 2\n", "fewer than three"},
                {"f 1/1 2/1 3/1\n", "texture coordinate 0 of 0"},
                {"f 1//1 2//1 3//1\n", "normal 0 of 0"},
                {"v 1 2\n", "number is missing"},
                {"v 1 2 nan\n", "malformed"},
                {"v 1 2 2e30\n", "beyond 2^30"}};
  for (const auto& [line, part] : faults)
    EXPECT_NE(reason(parse_obj(corners + line)).find(part), std::string::npos)
        << line << reason(parse_obj(corners + line));
}

TEST(MjcfMeshFormats, CountsMatchTheContents) {
  const std::string corners = words({0, 0, 0, kOne, 0, 0, 0, kOne, 0, 0, 0, kOne});
  const std::string sides = words({0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3});
  const std::string msh = words({4, 0, 0, 4}) + corners + sides;
  const Result<MeshData> mesh = parse_msh(msh);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->faces[3], (MeshData::Triangle{1, 2, 3}));
  const std::string lies = "counts that differ from its contents";
  const struct {
    std::string bytes, part;
  } faults[] = {{msh + "more", lies},
                {msh.substr(0, msh.size() - 1), lies},
                {words({4, 0}), lies},
                {words({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}), lies},
                {words({0x55555556, 0, 0, 0, 0, 0}), lies},
                {words({4, 3, 0, 0}) + corners + words({0, 0, 0, 0, 0, 0, 0, 0, 0}), "some vertices only"},
                {words({4, 0, 0, 1}) + corners + words({0, 1, 4}), "vertex 4 of 4"},
                {words({1, 0, 0, 0, kNan, 0, 0}), "not finite"}};
  for (const auto& [bytes, part] : faults)
    EXPECT_NE(reason(parse_msh(bytes)).find(part), std::string::npos) << reason(parse_msh(bytes));

  const std::string stl = test::binary_stl();
  EXPECT_EQ(parse_stl(stl)->vertices.size(), 3u);
  EXPECT_NE(reason(parse_stl(stl.substr(0, stl.size() - 1))).find(lies), std::string::npos);
  EXPECT_NE(reason(parse_stl(stl.substr(0, 80) + words({0xffffffff}) + stl.substr(84))).find(lies),
            std::string::npos);
  EXPECT_NE(reason(parse_stl("short")).find(lies), std::string::npos);
  EXPECT_NE(reason(parse_stl(test::kAsciiStl)).find("is text"), std::string::npos);

  EXPECT_NE(reason(parse_inline_mesh({"0 0 0 1 0 0 0 1 0", "", "", "0 1 3"})).find("vertex 3 of 3"),
            std::string::npos);
  EXPECT_NE(reason(parse_inline_mesh({"0 0 0 1 0 0 0 1 0", "", "", "0 1 -1"})).find("vertex -1 of 3"),
            std::string::npos);
  EXPECT_NE(reason(parse_inline_mesh({"0 0 0 1", "", "", ""})).find("not a multiple of 3"),
            std::string::npos);
  EXPECT_NE(reason(parse_inline_mesh({"0 0 x", "", "", ""})).find("something else than numbers"),
            std::string::npos);
}

TEST(MjcfHull, EnclosesAllPoints) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 300; ++i) {  // on and within a ball, with repeated and inner points
    const float angle = 2.4f * static_cast<float>(i), z = static_cast<float>(i % 100) / 50 - 1;
    const float radius = (i < 200 ? 1.0f : 0.5f) * std::sqrt(std::max(0.0f, 1 - z * z));
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), i < 200 ? z : z / 2);
  }
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull.ok());
  double volume = 0;
  for (const MeshData::Triangle& face : *hull) {
    const glm::dvec3 a(points[face[0]]), b(points[face[1]]), c(points[face[2]]);
    volume += glm::dot(a, glm::cross(b, c)) / 6;
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    for (const glm::vec3& p : points) EXPECT_LE(glm::dot(normal, glm::dvec3(p) - a), 1e-7);
  }
  EXPECT_GT(volume, 3.5);
  EXPECT_LT(volume, 4.18880);
  EXPECT_NE(reason(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}})).find("in a plane"),
            std::string::npos);
  EXPECT_NE(reason(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})).find("fewer than 4"), std::string::npos);
  EXPECT_FALSE(convex_hull(std::vector<glm::vec3>(10, glm::vec3(1))).ok());
}

TEST(MjcfPatterns, PatternsMatchMuJoCo) {
  TexturePattern pattern{"checker", "", {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0.01, 4, 2};
  const auto pixel = [&](size_t row, size_t column) {
    const std::vector<uint8_t> rgb = draw_pattern(pattern);
    const size_t at = 3 * (row * pattern.width + column);
    return glm::ivec3(rgb[at], rgb[at + 1], rgb[at + 2]);
  };
  EXPECT_EQ(pixel(0, 0), glm::ivec3(255, 0, 0));
  EXPECT_EQ(pixel(0, 3), glm::ivec3(0, 0, 255));
  EXPECT_EQ(pixel(1, 3), glm::ivec3(255, 0, 0));
  pattern.mark = "edge";
  pattern.height = pattern.width = 9;
  EXPECT_EQ(pixel(8, 3), glm::ivec3(0, 255, 0));
  EXPECT_NE(pixel(4, 4), glm::ivec3(0, 255, 0));
  pattern.mark = "cross";
  EXPECT_EQ(pixel(4, 1), glm::ivec3(0, 255, 0));
  pattern.mark = "";
  pattern.kind = "gradient";
  EXPECT_EQ(pixel(4, 4), glm::ivec3(255, 0, 0)) << "the first colour is in the middle";
  EXPECT_EQ(pixel(0, 0), glm::ivec3(0, 0, 255));
}

TEST_F(Mjcf, TexturesAreFlippedDecodedAndBounded) {
  // Two pixels, red and blue, in MuJoCo's format.
  folder_.write("t.bin", std::string_view(words({2, 1}) + std::string("\xff\0\0\0\0\xff", 6)));
  const auto image = [&](const std::string& attributes) {
    const Result<Model> model =
        try_read("<mujoco><asset><texture name='t' type='2d' " + attributes +
                 "/><material name='m' texture='t'/></asset><worldbody><geom type='box' size='1 1 1' "
                 "material='m'/></worldbody></mujoco>");
    EXPECT_TRUE(model.ok());
    EXPECT_EQ(model->warnings.empty(), !model->images.empty()) << attributes;
    if (model->images.empty()) return std::string(model->warnings.empty() ? "" : model->warnings[0]);
    const Result<PngPixels> pixels = decode_png(model->images[0].bytes);
    return pixels ? std::string(pixels->rgb.begin(), pixels->rgb.end()) : pixels.error().message;
  };
  EXPECT_EQ(image("file='t.bin'"), std::string("\xff\0\0\0\0\xff", 6));
  EXPECT_EQ(image("file='t.bin' hflip='true'"), std::string("\0\0\xff\xff\0\0", 6));
  EXPECT_EQ(image("file='t.bin' vflip='true'"), std::string("\xff\0\0\0\0\xff", 6));
  EXPECT_NE(image("builtin='flat' width='100000' height='100000'").find("width times height"),
            std::string::npos);
  EXPECT_NE(image("builtin='flat' width='-1' height='1'").find("width times height"), std::string::npos);
  EXPECT_NE(image("file='gone.png'").find("does not exist"), std::string::npos);
  const std::vector<std::byte> png = test::png(2, 2, 0x00ff00ff);
  EXPECT_TRUE(decode_png(png).ok());
  EXPECT_FALSE(decode_png({png.data(), png.size() - 20}).ok());
  const std::string head =
      "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\x0dIHDR\0\0\x40\0\0\0\x40\0\x08\x02\0\0\0", 21);
  EXPECT_FALSE(decode_png(std::as_bytes(std::span(head))).ok());
}

TEST_F(Mjcf, HeightFieldsAreBoundedAndChecked) {
  const auto fault = [&](const std::string& attributes) {
    const Result<Model> model = try_read(
        "<mujoco><asset><hfield name='h' " + attributes +
        "/></asset><worldbody><geom type='hfield' hfield='h'/><geom size='1'/></worldbody></mujoco>");
    EXPECT_TRUE(model.ok());
    return model->warnings.empty() ? std::string("none") : model->warnings[0];
  };
  const std::string size = "size='1 1 1 1' ";
  EXPECT_EQ(fault(size + "nrow='2' ncol='2' elevation='0 1 2 3'"), "none");
  EXPECT_NE(fault(size + "nrow='2' ncol='2' elevation='0 1 2'").find("nrow times ncol"), std::string::npos);
  EXPECT_NE(fault(size + "nrow='100000' ncol='100000'").find("more than 16777216"), std::string::npos);
  EXPECT_NE(fault(size + "nrow='-2' ncol='2'").find("positive nrow"), std::string::npos);
  EXPECT_NE(fault("size='1 1 0 1' nrow='2' ncol='2'").find("four positive numbers"), std::string::npos);
  folder_.write("h.bin", std::string_view(words({0x10001, 0x10000, 0, 0})));
  EXPECT_NE(fault(size + "file='h.bin'").find("more than 16777216"), std::string::npos);
  folder_.write("h.bin", std::string_view(words({2, 2, 0, 0, 0})));
  EXPECT_NE(fault(size + "file='h.bin'").find("counts that differ"), std::string::npos);
  folder_.write("h.bin", std::string_view(words({2, 2, 0, 0, 0, kNan})));
  EXPECT_NE(fault(size + "file='h.bin'").find("not finite"), std::string::npos);
}

TEST_F(Mjcf, SharpEdgesSplitNormals) {
  // A cube of twelve triangles with shared vertices: each side keeps its own normal unless the mesh is
  // smooth.
  const std::string cube =
      "vertex='0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1' face='0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 "
      "2 6 1 6 5 "
      "2 3 7 2 7 6 3 0 4 3 4 7'";
  for (const bool smooth : {false, true}) {
    const Result<Model> model =
        try_read("<mujoco><asset><mesh name='m' " + cube + (smooth ? " smoothnormal='true'" : "") +
                 "/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>");
    ASSERT_TRUE(model.ok());
    const Surface& surface = model->meshes[0].surfaces[0];
    const auto flat = std::count_if(surface.normals.begin(), surface.normals.end(), [](const glm::vec3& n) {
      return std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)}) > 0.999f;
    });
    EXPECT_EQ(surface.positions.size(), smooth ? 8u : 24u);
    EXPECT_EQ(flat, smooth ? 0 : 24);
  }
}

}  // namespace
}  // namespace fire3dv::convert
