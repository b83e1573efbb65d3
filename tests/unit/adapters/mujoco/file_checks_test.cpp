// Security test of MJCF assets with false counts, which libmujoco trusts.
#include <gtest/gtest.h>

#include <bit>

#include "tests/unit/adapters/mujoco/compiled_mjcf.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

// libmujoco would read beyond the end of the mesh.
TEST_F(CompiledMjcf, FacesMatchVertices) {
  constexpr const char* kModel = "<mujoco><asset><mesh name='m' file='m.obj'/></asset><worldbody/></mujoco>";
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n", sides = "f 1 3 2\nf 1 2 4\nf 1 4 3\n";
  const auto fault = [&](const std::string& last, const std::string& first = "") {
    folder_.write("m.obj", std::string_view(first + corners + sides + last));
    const auto model = try_read(kModel);
    return model.ok() ? std::string("none") : model.error().message;
  };
  EXPECT_EQ(fault("f 2 3 4\n"), "none");
  EXPECT_EQ(fault("\t f -3 -2 -1\r\n"), "none");
  EXPECT_EQ(fault("f 5 6 4\nv 1 0 0\nv 0 1 0\n"), "none");  // the vertices follow the faces
  const std::string whole =
      "vt 0 0\nvn 0 0 1\n" + corners + "f 1/1/1 3/1/1 2/1/1\nf 1/1/1 2/1/1 4/1/1\nf 1/1/1 4/1/1 3/1/1\n";
  folder_.write("m.obj", std::string_view(whole + "f 2/1/1 3/-1/-1 4/1/1\n"));
  EXPECT_TRUE(try_read(kModel).ok());
  const struct {
    const char *face, *named;
  } cases[] = {{"f 2 3 5", "names corner 5 of 4"},
               {"f 2 3 99999999999999999999", "names corner"},
               {"f -5 3 4", "names corner -1 of 4"},
               {"f -2147483648 3 4", "names corner"},
               {"\r\t f\t2 3 \v9", "names corner 9 of 4"},
               {"l 2 7", "names corner 7 of 4"},
               {"f 2/1 3/1 4/1", "names texture coordinate 1 of 0"},
               {"vt 0 0\nf 2/1 3/1 4/2/", "names texture coordinate 2 of 1"},
               {"f 2//1 3//1 4//1", "names normal 1 of 0"},
               {"vt 0 0\nvn 0 0 1\nf 2/1/1 3/1/1 4/1/-2", "names normal -1 of 1"},
               {"vt 0 0\nf 2/1 3/1 4/1", "has a texture coordinate for some corners"},
               {"vn 0 0 1\nf 2 3 4", "has a normal for some corners"}};
  for (const auto& [face, named] : cases) {
    const std::string message = fault(face);
    EXPECT_NE(message.find("m.obj\" " + std::string(named)), std::string::npos) << face << ": " << message;
  }
}

// Without faces libmujoco builds a convex hull of the vertices, and assumes that all attributes have their
// count.
TEST_F(CompiledMjcf, FacelessMeshHasHull) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  const auto fault = [&](const std::string& text) {
    folder_.write("m.obj", std::string_view(text));
    const auto model = try_read(
        "<mujoco><asset><mesh name='m' file='m.obj' scale='2 2 2'/></asset><worldbody><geom type='mesh' "
        "mesh='m'/></worldbody></mujoco>");
    return model.ok() ? std::string("none") : model.error().message;
  };
  EXPECT_EQ(fault(corners), "none");
  EXPECT_NE(fault("v 0 0 0\nv 1 0 0\nv 0 1 0\n").find("has no faces and only 3 corners"), std::string::npos);
  for (const char* one : {"vn 0 0 1\n", "vt 0 0\n"})
    EXPECT_NE(fault(corners + one).find("has no faces, 4 corners, and 1"), std::string::npos) << one;
}

// libmujoco multiplies the counts in 32 bits, and accesses memory by the product.
TEST_F(CompiledMjcf, CountsMatchTheContents) {
  const auto bytes = [](std::initializer_list<uint32_t> words) {
    std::string text;
    for (const uint32_t word : words) text += test::raw(word);
    return text;
  };
  const auto fault = [&](const std::string& assets, const std::string& file = "",
                         const std::string& data = "") {
    if (!file.empty()) folder_.write(file, std::string_view(data));
    const auto model =
        try_read("<mujoco><asset>" + assets + "</asset><worldbody><body name='b'/></worldbody></mujoco>");
    return model.ok() ? std::string("none") : model.error().message;
  };
  const auto mesh = [&](const std::string& file, const std::string& data) {
    return fault("<mesh name='m' file='" + file + "'/>", file, data);
  };
  const uint32_t one = std::bit_cast<uint32_t>(1.0f), nan = 0x7fc00000;
  const std::string corners = bytes({0, 0, 0, one, 0, 0, 0, one, 0, 0, 0, one});
  const std::string sides = bytes({0, 2, 1, 0, 1, 3, 0, 3, 2}), last = bytes({1, 2, 3});
  const std::string msh = bytes({4, 0, 0, 4}) + corners + sides;
  EXPECT_EQ(mesh("m.msh", msh + last), "none");
  EXPECT_EQ(mesh("m.msh", bytes({4, 0, 0, 0}) + corners), "none") << "its hull";
  const std::string lies = "\" has counts that differ from its contents";
  const struct {
    std::string data, message;
  } meshes[] = {{msh, lies},
                {msh + last + "more", lies},
                {bytes({4, 0}), lies},
                {bytes({0x80000000, 0, 0, 0}), lies},
                {bytes({0x55555556, 0, 0, 0, 0, 0}), lies},  // three times it is 2 (mod 2^32)
                {msh + bytes({1, 2, 4}), "\" has a face that names corner 4 of 4"},
                {msh + bytes({1, 2, 0xffffffff}), "\" has a face that names corner -1 of 4"},
                {bytes({4, 0, 0, 0, nan}) + corners.substr(4), "\" has a corner that is not finite"}};
  for (const auto& [data, message] : meshes)
    EXPECT_NE(mesh("m.MSH", data).find("m.MSH" + message), std::string::npos) << mesh("m.MSH", data);
  // libmujoco checks these counts itself.
  const std::string stl = test::binary_stl();
  EXPECT_NE(mesh("m.stl", stl.substr(0, stl.size() - 1)).find("wrong size"), std::string::npos);
  EXPECT_NE(mesh("m.stl", stl.substr(0, 80) + bytes({0x51eb851f}) + stl.substr(84)).find("faces"),
            std::string::npos);

  const auto skin = [&](const std::string& data) {
    return fault("<skin name='s' file='s.skn'/>", "s.skn", data);
  };
  const std::string bone = "b" + std::string(39, '\0') + bytes({0, 0, 0, one, 0, 0, 0});
  const std::string skn = bytes({4, 0, 4, 1}) + corners + sides + last + bone;
  const std::string moved = bytes({0, 1, 2, 3, one, one, one, one});
  EXPECT_EQ(skin(skn + bytes({4}) + moved), "none");
  for (const std::string& data : {skn + bytes({5}) + moved, skn + bytes({0x40000001}) + moved,
                                  bytes({4, 0, 0x15555556, 1}) + corners, bytes({0, 0, 0, 0x7fffffff})})
    EXPECT_NE(skin(data).find("s.skn" + lies), std::string::npos) << skin(data);
  EXPECT_NE(skin(bytes({4, 0, 4, 0}) + corners + sides + bytes({1, 2, 7})).find("corner 7 of 4"),
            std::string::npos);

  const auto field = [&](const std::string& data) {
    return fault("<hfield name='h' file='h.bin' size='1 1 1 1'/>", "h.bin", data);
  };
  EXPECT_EQ(field(bytes({2, 1, 0, one})), "none");
  EXPECT_NE(field(bytes({0x10001, 0x10000, 0, 0})).find("h.bin" + lies), std::string::npos);
  EXPECT_NE(field("short").find("h.bin" + lies), std::string::npos);
  const auto texture = [&](const std::string& type, const std::string& file, const std::string& data) {
    return fault("<texture name='t' type='" + type + "' file='" + file + "'/>", file, data);
  };
  EXPECT_EQ(texture("2d", "t.bin", bytes({2, 2}) + std::string(12, 'c')), "none");
  EXPECT_NE(texture("2d", "t.bin", bytes({0x55555556, 1, 0})).find("t.bin" + lies), std::string::npos);
  EXPECT_NE(texture("2d", "t.bin", "x").find("t.bin" + lies), std::string::npos);
  // Only the header of the image is read: libmujoco's cube map has six sides of it.
  const std::string head = "\x89PNG\r\n\x1a\n" + std::string("\0\0\0\x0dIHDR\0\0\x40\0\0\0\x40\0", 16);
  EXPECT_NE(texture("cube", "t.png", head).find("t.png\" has, with the textures"), std::string::npos);
  EXPECT_EQ(texture("2d", "t.png", head).find("with the textures"), std::string::npos);

  const struct {
    const char *assets, *message;
  } own[] = {
      {"<mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 999999'/>", "corner 999999 of 4"},
      {"<mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 -1'/>", "corner -1 of 4"},
      {"<mesh name='m' file='m.msh' face='0 1 2'/>", "its mesh \"m\" has a file and faces of its own"},
      {"<skin name='s' vertex='0 0 0' face='0 1 2'/>", "its skin \"s\" has a face that names corner 1 of 1"},
      {"<hfield name='h' nrow='65537' ncol='65536' size='1 1 1 1'/>",
       "its hfield \"h\" has, with the height fields"},
      {"<texture name='t' builtin='flat' width='15447' height='1'/>",
       "its texture \"t\" has, with the textures"},
      {"<texture name='t' type='2d' builtin='flat' width='40000' height='40000'/>",
       "more than 2147483647 numbers"}};
  for (const auto& [assets, message] : own)
    EXPECT_NE(fault(assets).find(message), std::string::npos) << fault(assets);
  EXPECT_EQ(fault("<mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3'/>"),
            "none");
}

}  // namespace
}  // namespace fire3dv::convert
