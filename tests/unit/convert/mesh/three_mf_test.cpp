// Test of 3MF files as scenes: unit, tree, names, colours and textures, and hostile archives.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>

#include "convert/glb/write_glb.h"
#include "convert/readers.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

struct File {
  std::string name, contents;
};

// Archive after PKWARE's APPNOTE.TXT, with deflated files.
std::string zip(const std::vector<File>& files) {
  std::string bytes, directory;
  for (const File& file : files) {
    std::string packed(compressBound(file.contents.size()) + 64, '\0');
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(file.contents.data()));
    stream.avail_in = static_cast<uInt>(file.contents.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    const auto checksum = static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(file.contents.data()),
                                                      static_cast<uInt>(file.contents.size())));
    const std::string both = test::raw<uint16_t>(20) + test::raw<uint16_t>(0) + test::raw<uint16_t>(8) +
                             test::raw<uint32_t>(0) + test::raw(checksum) +
                             test::raw(static_cast<uint32_t>(packed.size())) +
                             test::raw(static_cast<uint32_t>(file.contents.size())) +
                             test::raw(static_cast<uint16_t>(file.name.size())) + test::raw<uint16_t>(0);
    directory += "PK\x01\x02" + test::raw<uint16_t>(20) + both + std::string(10, '\0') +
                 test::raw(static_cast<uint32_t>(bytes.size())) + file.name;
    bytes += "PK\x03\x04" + both + file.name + packed;
  }
  const auto count = static_cast<uint16_t>(files.size());
  return bytes + directory + "PK\x05\x06" + std::string(4, '\0') + test::raw(count) + test::raw(count) +
         test::raw(static_cast<uint32_t>(directory.size())) + test::raw(static_cast<uint32_t>(bytes.size())) +
         std::string(2, '\0');
}

const std::string kTriangle =
    "<vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"2\" "
    "z=\"0\"/></vertices>";

std::string model(const std::string& resources, const std::string& build, const std::string& unit = "inch") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"" + unit +
         "\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\">\n<resources>" +
         resources + "</resources><build>" + build + "</build></model>";
}

Result<Model> read_3mf(const test::ScratchFolder& folder, const std::string& name,
                       const std::vector<File>& files) {
  return read_description(folder.write(name, zip(files)), {});
}

TEST(ThreeMf, TreeAndMaterialsAreKept) {
  const test::ScratchFolder folder;
  const std::string resources =
      "<basematerials id=\"5\"><base name=\"Red plastic\" displaycolor=\"#FF8000\"/><base name=\"Glass\" "
      "displaycolor=\"#0000FF80\"/></basematerials>"
      "<object id=\"1\" name=\"part A\" type=\"model\" pid=\"5\" pindex=\"0\"><mesh>" +
      kTriangle +
      "<triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"5\" "
      "p1=\"1\"/>"
      "</triangles></mesh></object>"
      "<object id=\"2\" name=\"assembly\"><components>"
      "<component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/>"
      "<component objectid=\"1\" transform=\"0 2 0 -2 0 0 0 0 2 0 20 0\"/></components></object>";
  const Result<Model> read_model =
      read_3mf(folder, "a.3mf",
               {{"3D/3dmodel.model",
                 model(resources, "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 0 5\"/>")}});
  ASSERT_TRUE(read_model.ok()) << read_model.error().message;
  const Model& m = *read_model;
  EXPECT_TRUE(m.warnings.empty());
  ASSERT_EQ(m.nodes.size(), 3u);
  EXPECT_EQ(m.nodes[0].name, "assembly");
  EXPECT_EQ(m.nodes[1].name, "part A");
  EXPECT_EQ(m.nodes[1].parent, std::optional<size_t>(0));
  const double inch = 0.0254;
  EXPECT_NEAR(m.nodes[0].translation.z, 5 * inch, 1e-9);
  EXPECT_NEAR(m.nodes[1].translation.x, 10 * inch, 1e-9);
  EXPECT_NEAR(m.nodes[2].translation.y, 20 * inch, 1e-9);
  // The second component turns x to y and doubles the size: the turn is in the node, the size in the
  // vertices.
  EXPECT_NEAR((m.nodes[2].rotation * glm::dvec3(1, 0, 0)).y, 1, 1e-6);
  EXPECT_EQ(m.nodes[2].scale, glm::dvec3(1));
  const auto longest = [&](size_t node) {
    float most = 0;
    for (const Surface& s : m.meshes[*m.nodes[node].mesh].surfaces)
      for (const glm::vec3& p : s.positions) most = std::max(most, glm::length(p));
    return most;
  };
  EXPECT_NEAR(longest(1), 2 * inch, 1e-6);
  EXPECT_NEAR(longest(2), 4 * inch, 1e-6);
  const std::vector<Surface>& surfaces = m.meshes[*m.nodes[1].mesh].surfaces;
  ASSERT_EQ(surfaces.size(), 2u);
  const Material& red = m.materials[surfaces[0].material];
  EXPECT_EQ(red.name, "Red plastic");
  EXPECT_LT(glm::length(red.base_color - linear_from_srgb(glm::vec4(1, 128.0f / 255, 0, 1))), 1e-5f);
  const Material& glass = m.materials[surfaces[1].material];
  EXPECT_EQ(glass.name, "Glass");
  EXPECT_NEAR(glass.base_color.a, 128.0f / 255, 1e-5f);
  EXPECT_TRUE(glass.blended);
  EXPECT_TRUE(write_glb(m).ok());
}

TEST(ThreeMf, ColoursTexturesModelsAreRead) {
  const test::ScratchFolder folder;
  const std::vector<uint8_t> white = {255, 255, 255};
  const auto png = png_of(white, 1, 1, 3);
  ASSERT_TRUE(png.ok());
  const std::string image(reinterpret_cast<const char*>(png->data()), png->size());
  const std::string resources =
      "<m:colorgroup id=\"6\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00\"/><m:color "
      "color=\"#0000FF\"/>"
      "</m:colorgroup><m:texture2d id=\"7\" path=\"/3D/Textures/a.png\" contenttype=\"image/png\"/>"
      "<m:texture2dgroup id=\"8\" texid=\"7\"><m:tex2coord u=\"0\" v=\"0.25\"/><m:tex2coord u=\"1\" v=\"1\"/>"
      "</m:texture2dgroup><object id=\"1\"><mesh>" +
      kTriangle +
      "<triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"6\" p1=\"0\" p2=\"1\" p3=\"2\"/>"
      "<triangle v1=\"0\" v2=\"2\" v3=\"1\" pid=\"8\" p1=\"0\" p2=\"1\" "
      "p3=\"1\"/></triangles></mesh></object>";
  // The production extension keeps objects in further models.
  const std::string root = model(
      "<object id=\"9\" name=\"all\"><components><component p:path=\"/3D/Objects/part.model\" "
      "objectid=\"1\"/></components></object>",
      "<item objectid=\"9\"/>", "millimeter");
  const Result<Model> m = read_3mf(folder, "a.3mf",
                                   {{"_rels/.rels",
                                     "<Relationships><Relationship Target=\"/3D/root.model\" Id=\"r\" "
                                     "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
                                     "</Relationships>"},
                                    {"3D/root.model", root},
                                    {"3D/Objects/part.model", model(resources, "", "millimeter")},
                                    {"3D/Textures/a.png", image}});
  ASSERT_TRUE(m.ok()) << m.error().message;
  ASSERT_EQ(m->nodes.size(), 2u);
  ASSERT_TRUE(m->nodes[1].mesh);
  const std::vector<Surface>& surfaces = m->meshes[*m->nodes[1].mesh].surfaces;
  ASSERT_EQ(surfaces.size(), 2u);
  const Surface& coloured = surfaces[0];
  ASSERT_EQ(coloured.colors.size(), 3u);
  EXPECT_EQ(coloured.colors[coloured.indices[1]], glm::vec4(0, 1, 0, 1));
  EXPECT_EQ(coloured.positions[coloured.indices[1]], glm::vec3(0.001f, 0, 0));
  EXPECT_EQ(m->materials[coloured.material].base_color, glm::vec4(1));
  const Surface& textured = surfaces[1];
  ASSERT_EQ(textured.uvs.size(), textured.positions.size());
  EXPECT_EQ(textured.uvs[textured.indices[0]], glm::vec2(0, 0.75f));
  const Material& material = m->materials[textured.material];
  ASSERT_TRUE(material.base_color_image);
  EXPECT_EQ(m->images[*material.base_color_image].bytes, *png);
}

TEST(ThreeMf, RefusalsNameTheReason) {
  const test::ScratchFolder folder;
  const auto refusal = [&](const std::string& bytes) {
    const Result<Model> m = read_description(folder.write("a.3mf", bytes), {});
    if (m) return std::string("read");
    EXPECT_NE(m.error().message.find("a.3mf"), std::string::npos) << m.error().message;
    EXPECT_EQ(m.error().message.find('\n'), std::string::npos) << m.error().message;
    return m.error().message;
  };
  const auto says = [](const std::string& message, const char* what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  const auto of = [&](const std::string& resources, const std::string& build = "<item objectid=\"1\"/>") {
    return zip({{"3D/3dmodel.model", model(resources, build)}});
  };
  const auto object = [](const std::string& triangle) {
    return "<object id=\"1\"><mesh>" + kTriangle + "<triangles>" + triangle + "</triangles></mesh></object>";
  };
  const std::string good = of(object("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>"));
  EXPECT_EQ(refusal(good), "read");
  const std::string mixed = "<m:compositematerials id=\"4\" matid=\"5\" matindices=\"0\"/>";
  const Result<Model> composite = read_description(
      folder.write("b.3mf", of(mixed + object("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>"))), {});
  ASSERT_TRUE(composite.ok()) << composite.error().message;
  ASSERT_EQ(composite->warnings.size(), 1u);
  EXPECT_NE(composite->warnings[0].find("compositematerials"), std::string::npos) << composite->warnings[0];
  says(refusal(good.substr(0, good.size() / 2)), "cut short");
  says(refusal(zip({{"x.txt", "x"}})), "without a 3MF model");
  says(refusal(of(object("<triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"))), "vertex that is not there");
  says(refusal(of(object("<triangle v1=\"0\" v2=\"1\" v3=\"-1\"/>"))), "vertex that is not there");
  says(refusal(of("", "<item objectid=\"4\"/>")), "object that is not there");
  says(refusal(of("<object id=\"1\"><components><component objectid=\"1\"/></components></object>")),
       "contain themselves");
  says(refusal(of("<object id=\"1\"><mesh><vertices><vertex x=\"nan\" y=\"0\" z=\"0\"/></vertices>"
                  "<triangles><triangle v1=\"0\" v2=\"0\" v3=\"0\"/></triangles></mesh></object>")),
       "not finite");
  says(refusal(of(object(""))), "no triangle");
  says(refusal(zip({{"3D/3dmodel.model", model("", "", "parsec")}})), "unit");
  says(refusal(zip({{"3D/3dmodel.model", "<model>"}})), "line 1");
  // A file that claims to unpack to 4 GiB.
  std::string huge = good;
  const size_t entry = huge.find("PK\x01\x02");
  huge.replace(entry + 24, 4, "\xff\xff\xff\xff");
  says(refusal(huge), "MiB");
  // Two components of two components, and so on: few bytes, many nodes.
  std::string tree = object("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>");
  for (int id = 2; id < 40; ++id) {
    const std::string component = "<component objectid=\"" + std::to_string(id - 1) + "\"/>";
    tree += "<object id=\"" + std::to_string(id) + "\"><components>" + component + component +
            "</components></object>";
  }
  says(refusal(of(tree, "<item objectid=\"39\"/>")), "too many components");
  uint32_t random = 3;
  for (size_t i = 0; i < 60; ++i) {
    std::string damaged = good;
    for (size_t k = 0; k < 1 + i / 10; ++k) {
      random = random * 1664525 + 1013904223;
      damaged[(random >> 8) % damaged.size()] = static_cast<char>(random >> 3);
    }
    (void)refusal(damaged);
  }
}

}  // namespace
}  // namespace fire3dv::convert
