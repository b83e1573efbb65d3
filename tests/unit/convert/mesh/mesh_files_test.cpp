// Test of the mesh file readers: the conventions of each format, refusals, and damaged files.
#include "convert/mesh/mesh_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/epsilon.hpp>
#include <numbers>
#include <optional>

#include "convert/model.h"
#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::convert {
namespace {

struct Loaded {
  Model model;
  Result<std::vector<Surface>> surfaces = Error{"not read"};
};

Loaded load(const std::filesystem::path& file, const glm::dvec3& scale = glm::dvec3(1)) {
  Loaded loaded;
  MeshFiles files(loaded.model);
  loaded.surfaces = files.surfaces(file, scale);
  return loaded;
}

size_t triangles(const std::vector<Surface>& surfaces) {
  size_t count = 0;
  for (const Surface& s : surfaces) count += s.indices.size() / 3;
  return count;
}

glm::vec3 face_normal(const Surface& s, size_t triangle = 0) {
  const glm::vec3 a = s.positions[s.indices[triangle * 3]], b = s.positions[s.indices[triangle * 3 + 1]],
                  c = s.positions[s.indices[triangle * 3 + 2]];
  return glm::normalize(glm::cross(b - a, c - a));
}

TEST(MeshFiles, ObjIsTriangulated) {
  const test::ScratchFolder folder;
  folder.write("some colours.mtl", test::kMtl);
  folder.write("the image.png", "an image's bytes");
  const Loaded loaded = load(folder.write("a mesh with blanks.OBJ", test::kObj));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  EXPECT_TRUE(loaded.model.warnings.empty()) << loaded.model.warnings[0];
  ASSERT_EQ(loaded.surfaces->size(), 2u);
  const auto by_name = [&](const char* name) -> const Surface& {
    for (const Surface& s : *loaded.surfaces)
      if (loaded.model.materials[s.material].name == name) return s;
    ADD_FAILURE() << "nothing has the material " << name;
    return loaded.surfaces->front();
  };
  const Surface& red = by_name("red one");
  EXPECT_EQ(red.indices.size(), (1 + 3) * 3u);  // a triangle, and the fan of a pentagon
  ASSERT_EQ(red.uvs.size(), red.positions.size());
  ASSERT_EQ(red.normals.size(), red.positions.size());
  for (const glm::vec3& n : red.normals) EXPECT_EQ(n, glm::vec3(0, 0, 1));  // normalised
  for (size_t v = 0; v < red.positions.size(); ++v) {
    if (red.positions[v] != glm::vec3(1, 0, 0)) continue;
    EXPECT_EQ(red.uvs[v], glm::vec2(1, 0.75f));
  }
  const Material& m = loaded.model.materials[red.material];
  EXPECT_EQ(m.base_color, glm::vec4(linear_from_srgb({0.5f, 0, 1}), 1));
  EXPECT_EQ(m.emission, linear_from_srgb({0, 0.5f, 0}));
  EXPECT_FLOAT_EQ(m.roughness, std::sqrt(2 / (1.28f * 1.28f * 10 + 2)));
  EXPECT_FALSE(m.blended);
  ASSERT_TRUE(m.base_color_image);
  EXPECT_EQ(loaded.model.images[*m.base_color_image].bytes.size(), 16u);

  const Surface& glass = by_name("glass");
  EXPECT_EQ(glass.indices.size(), 3u);
  EXPECT_TRUE(glass.uvs.empty());
  EXPECT_EQ(loaded.model.materials[glass.material].base_color, glm::vec4(1, 1, 1, 0.25f));
  EXPECT_TRUE(loaded.model.materials[glass.material].blended);
  EXPECT_EQ(loaded.model.materials[glass.material].roughness, 1);  // no specular highlight
}

TEST(MeshFiles, BlackColourKeepsMap) {
  const test::ScratchFolder folder;
  folder.write("a.png", "an image's bytes");
  folder.write("some colours.mtl", "newmtl red one\nKd 0 0 0\nmap_Kd a.png\nnewmtl glass\nKd 0 0 0\n");
  const Loaded loaded = load(folder.write("a.obj", test::kObj));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  for (const Surface& surface : *loaded.surfaces) {
    const Material& m = loaded.model.materials[surface.material];
    EXPECT_EQ(glm::vec3(m.base_color), glm::vec3(m.base_color_image ? 1.0f : 0.0f)) << m.name;
  }
}

TEST(MeshFiles, MissingMaterialsAreReported) {
  const test::ScratchFolder folder;
  const Loaded loaded = load(folder.write("a.obj", test::kObj));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  EXPECT_EQ(triangles(*loaded.surfaces), 5u);
  ASSERT_EQ(loaded.model.warnings.size(), 1u);
  EXPECT_NE(loaded.model.warnings[0].find("a.obj\" has no materials: \"some colours.mtl\""),
            std::string::npos)
      << loaded.model.warnings[0];
}

// Facets of a fan around the z axis, 20 degrees apart, above a floor that meets them at 90 degrees.
TEST(MeshFiles, StlIsSmoothBelowAnAngle) {
  const test::ScratchFolder folder;
  std::string text = "solid s\n";
  const auto facet = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const glm::vec3& p : {a, b, c})
      text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
    text += "endloop\nendfacet\n";
  };
  const auto around = [](int i, float z) {
    const double angle = i * 20 * std::numbers::pi / 180;
    return glm::vec3(std::cos(angle), std::sin(angle), z);
  };
  for (int i = 0; i < 3; ++i) {
    // At an inner vertex one facet has two triangles, and the other has one: it counts as much.
    facet(around(i, 0), around(i + 1, 0), around(i + 1, 1));
    facet(around(i, 0), around(i + 1, 1), around(i, 1));
    facet({0, 0, 0}, around(i + 1, 0), around(i, 0));
  }
  const auto file = folder.write("fan.stl", text + "endsolid s\n");
  const auto normals_at = [&](std::optional<double> angle_deg) {
    Model model;
    MeshFiles files(model);
    files.set_smooth_angle(angle_deg);
    const auto surfaces = files.surfaces(file);
    EXPECT_TRUE(surfaces) << surfaces.error().message;
    std::vector<glm::vec3> normals;
    const Surface& s = surfaces->front();
    for (size_t v = 0; v < s.normals.size(); ++v)
      if (glm::distance(s.positions[v], around(1, 0)) < 1e-4f) normals.push_back(s.normals[v]);
    return normals;
  };
  for (const std::optional<double> smooth : {std::optional<double>(), std::optional<double>(25)}) {
    const std::vector<glm::vec3> normals = normals_at(smooth);
    ASSERT_EQ(normals.size(), 2u) << "one of the fan, one of the floor";
    for (const glm::vec3& n : normals)
      EXPECT_LT(std::min(glm::distance(n, around(1, 0)), glm::distance(n, glm::vec3(0, 0, -1))), 1e-3f);
  }
  EXPECT_EQ(normals_at(15).size(), 3u) << "facets and floor";
  EXPECT_TRUE(normals_at(0).empty()) << "the loader makes flat normals";
}

TEST(MeshFiles, StlIsRead) {
  const test::ScratchFolder folder;
  const Loaded text = load(folder.write("a.stl", test::kAsciiStl));
  ASSERT_TRUE(text.surfaces) << text.surfaces.error().message;
  ASSERT_EQ(triangles(*text.surfaces), 2u);
  EXPECT_EQ(text.surfaces->front().positions.size(), 4u);
  const Loaded binary = load(folder.write("b.STL", test::binary_stl()), glm::dvec3(2, 2, 0.5));
  ASSERT_TRUE(binary.surfaces) << binary.surfaces.error().message;
  EXPECT_EQ(binary.surfaces->front().positions[1], glm::vec3(2, 0, 2.5));
  EXPECT_EQ(face_normal(binary.surfaces->front()), glm::vec3(0, 0, 1));
}

TEST(MeshFiles, MirroredMeshesKeepTheirOutside) {
  const test::ScratchFolder folder;
  folder.write("some colours.mtl", test::kMtl);
  const Loaded loaded = load(folder.write("a.obj", test::kObj), glm::dvec3(1, 1, -1));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  for (const Surface& s : *loaded.surfaces) {
    EXPECT_EQ(face_normal(s), glm::vec3(0, 0, -1));
    EXPECT_EQ(s.normals[0], glm::vec3(0, 0, -1));
  }
}

TEST(MeshFiles, AxesAreNativeUnitsMetres) {
  const test::ScratchFolder folder;
  const Loaded dae = load(folder.write("a.dae", test::kDae));
  ASSERT_TRUE(dae.surfaces) << dae.surfaces.error().message;
  ASSERT_EQ(dae.surfaces->size(), 1u);
  const std::vector<glm::vec3>& p = dae.surfaces->front().positions;
  ASSERT_EQ(p.size(), 3u);
  for (const glm::vec3& expected : {glm::vec3(0, 3, 0), glm::vec3(-1, 3, 0), glm::vec3(0, 3, 2)}) {
    EXPECT_TRUE(
        std::any_of(p.begin(), p.end(),
                    [&](const glm::vec3& at) { return glm::all(glm::epsilonEqual(at, expected, 1e-5f)); }))
        << expected.x << ' ' << expected.y << ' ' << expected.z;
  }
  // The mirror flips the winding twice: by the positions and by the vertex order.
  EXPECT_NEAR(face_normal(dae.surfaces->front()).y, -1, 1e-5);
  EXPECT_EQ(glm::vec3(dae.model.materials[dae.surfaces->front().material].base_color),
            linear_from_srgb({0.5f, 0.25f, 0}));

  const Loaded max = load(folder.write("a.3ds", test::three_ds()));
  ASSERT_TRUE(max.surfaces) << max.surfaces.error().message;
  EXPECT_EQ(triangles(*max.surfaces), 1u);
  EXPECT_NEAR(face_normal(max.surfaces->front()).y, -1, 1e-5);
  for (const glm::vec3& at : max.surfaces->front().positions) EXPECT_NEAR(at.y, 0, 1e-6);
}

TEST(MeshFiles, GltfKeepsMaterialAndImage) {
  const test::ScratchFolder folder;
  const auto png = test::png(2, 2, 0x00ff00ff);
  const std::string image(reinterpret_cast<const char*>(png.data()), png.size());
  const Loaded loaded = load(folder.write("a.glb", test::glb(image, "BLEND")));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  EXPECT_TRUE(loaded.model.warnings.empty()) << loaded.model.warnings[0];
  ASSERT_EQ(loaded.surfaces->size(), 1u);
  const Surface& surface = loaded.surfaces->front();
  ASSERT_EQ(surface.positions.size(), 3u);
  EXPECT_EQ(surface.positions[surface.indices[1]], glm::vec3(1, 0, 3)) << "the axes are the file's";
  EXPECT_EQ(surface.positions[surface.indices[2]], glm::vec3(0, 2, 3));
  EXPECT_EQ(surface.uvs.at(surface.indices[2]), glm::vec2(0, 0.25f));
  const Material& m = loaded.model.materials[surface.material];
  EXPECT_EQ(m.name, "paint");
  EXPECT_NEAR(m.base_color.r, 0.25f, 1e-5f);
  EXPECT_NEAR(m.base_color.g, 1, 1e-5f);
  EXPECT_EQ(m.base_color.a, 0.5f);
  EXPECT_TRUE(m.blended);
  EXPECT_FLOAT_EQ(m.metallic, 0.75f);
  EXPECT_FLOAT_EQ(m.roughness, 0.125f);
  ASSERT_TRUE(m.base_color_image);
  const std::vector<std::byte>& stored = loaded.model.images[*m.base_color_image].bytes;
  ASSERT_GT(stored.size(), 8u);
  EXPECT_EQ(static_cast<char>(stored[1]), 'P');
  const Loaded opaque = load(folder.write("b.glb", test::glb(image, "OPAQUE")));
  ASSERT_TRUE(opaque.surfaces);
  EXPECT_EQ(opaque.model.materials[opaque.surfaces->front().material].base_color.a, 1);
}

TEST(MeshFiles, PlyIsRead) {
  const test::ScratchFolder folder;
  const Loaded loaded = load(folder.write("a.ply", test::kPly));
  ASSERT_TRUE(loaded.surfaces) << loaded.surfaces.error().message;
  EXPECT_EQ(triangles(*loaded.surfaces), 1u);
  EXPECT_EQ(face_normal(loaded.surfaces->front()), glm::vec3(0, 0, 1));
  // A quad in both binary forms, with normals, a comment and elements that are not drawn.
  for (const bool big : {false, true}) {
    const auto number = [&](auto value) {
      std::string bytes = test::raw(value);
      if (big) std::reverse(bytes.begin(), bytes.end());
      return bytes;
    };
    std::string file =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty double y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "element edge 1\nproperty short a\nelement face 1\nproperty list uchar uint vertex_index\n"
        "property uchar red\nend_header\n";
    for (const glm::vec2 p : {glm::vec2(0, 0), {1, 0}, {1, 2}, {0, 2}})
      file += number(p.x) + number(double{p.y}) + number(5.0f) + number(0.0f) + number(0.0f) + number(2.0f);
    file += number(int16_t{-3}) + number(uint8_t{4});
    for (const uint32_t i : {0, 1, 2, 3}) file += number(i);
    const Loaded quad = load(folder.write("quad.ply", file + number(uint8_t{7})));
    ASSERT_TRUE(quad.surfaces) << quad.surfaces.error().message;
    EXPECT_EQ(triangles(*quad.surfaces), 2u);
    EXPECT_EQ(quad.surfaces->front().positions[2], glm::vec3(1, 2, 5));
    EXPECT_EQ(quad.surfaces->front().normals[0], glm::vec3(0, 0, 1));
    EXPECT_FALSE(load(folder.write("cut.ply", file)).surfaces) << "the last byte is missing";
  }
}

TEST(MeshFiles, PlaceholderMaterialsAreIgnored) {
  const test::ScratchFolder folder;
  const auto is_default = [&](const std::filesystem::path& file) {
    Model model;
    MeshFiles files(model);
    const auto surfaces = files.surfaces(file);
    EXPECT_TRUE(surfaces.ok()) << file;
    return surfaces && files.is_default(surfaces->front().material);
  };
  EXPECT_TRUE(is_default(folder.write("a.obj", test::kObj))) << "its material file is missing";
  EXPECT_TRUE(is_default(folder.write("a.stl", test::binary_stl())));
  EXPECT_TRUE(is_default(folder.write("a.ply", test::kPly)));
  EXPECT_FALSE(is_default(folder.write("a.dae", test::kDae)));
  EXPECT_FALSE(is_default(folder.write("a.glb", test::glb("x", "OPAQUE"))));
  folder.write("some colours.mtl", test::kMtl);
  EXPECT_FALSE(is_default(folder.write("b.obj", test::kObj)));
}

TEST(MeshFiles, DaeAxesAreOptional) {
  const test::ScratchFolder folder;
  std::string y_up = test::kDae;
  y_up.replace(y_up.find("Z_UP"), 4, "Y_UP");
  const auto highest = [&](const std::string& text, bool apply) {
    Model model;
    MeshFiles files(model);
    if (apply) files.apply_dae_up();
    const auto surfaces = files.surfaces(folder.write("a.dae", text));
    glm::vec3 most(-1e9f);
    if (surfaces)
      for (const glm::vec3& p : surfaces->front().positions) most = glm::max(most, p);
    return most;
  };
  const auto near = [](const glm::vec3& a, const glm::vec3& b) {
    return glm::all(glm::epsilonEqual(a, b, 1e-5f));
  };
  // The file's triangle reaches to (0, 3, 2) metres.
  EXPECT_TRUE(near(highest(test::kDae, false), {0, 3, 2}));
  EXPECT_TRUE(near(highest(test::kDae, true), {0, 3, 2}));
  EXPECT_TRUE(near(highest(y_up, false), {0, 3, 2}));
  EXPECT_TRUE(near(highest(y_up, true), {0, 0, 3})) << "y becomes z, and z becomes -y";
}

TEST(MeshFiles, DaeMaterialsAreNeverInvisible) {
  const test::ScratchFolder folder;
  const auto opacity = [&](const std::string& transparency) {
    std::string text = test::kDae;
    const std::string lambert = "</lambert>";
    text.insert(text.find(lambert), transparency);
    const Loaded loaded = load(folder.write("a.dae", text));
    return loaded.surfaces ? loaded.model.materials[loaded.surfaces->front().material].base_color.a : -1;
  };
  const std::string black = "<transparent opaque=\"A_ONE\"><color>0 0 0 1</color></transparent>";
  EXPECT_EQ(opacity(black + "<transparency><float>0</float></transparency>"), 1);
  EXPECT_EQ(opacity(black + "<transparency><float>1</float></transparency>"), 1);
  EXPECT_FLOAT_EQ(opacity(black + "<transparency><float>0.5</float></transparency>"), 0.5f);
  EXPECT_EQ(opacity("<transparency><float>0</float></transparency>"), 1);
  EXPECT_EQ(opacity("<transparency><float>1</float></transparency>"), 1);
}

TEST(MeshFiles, ImagesStayInTheirFolders) {
  const test::ScratchFolder folder;
  namespace fs = std::filesystem;
  fs::create_directories(folder.path() / "meshes");
  fs::create_directories(folder.path() / "images");
  folder.write("images/secret.png", "outside");
  fs::create_symlink(folder.path() / "images/secret.png", folder.path() / "meshes/link.png");
  const auto images_of = [&](const std::string& name, bool allow) {
    folder.write("meshes/some colours.mtl", "newmtl glass\nnewmtl red one\nKd 1 1 1\nmap_Kd " + name + "\n");
    const fs::path mesh = folder.write("meshes/a.obj", test::kObj);
    Model model;
    MeshFiles files(model);
    if (allow) files.allow_images_below(folder.path() / "images");
    EXPECT_TRUE(files.surfaces(mesh));
    EXPECT_EQ(model.warnings.size(), 1 - model.images.size());
    for (const std::string& warning : model.warnings) EXPECT_NE(warning.find("a.obj"), std::string::npos);
    return model.images.size();
  };
  EXPECT_EQ(images_of("../images/secret.png", false), 0u);
  EXPECT_EQ(images_of("../images/secret.png", true), 1u);
  EXPECT_EQ(images_of((folder.path() / "images/secret.png").string(), false), 0u);
  EXPECT_EQ(images_of("link.png", false), 0u);
  EXPECT_EQ(images_of("/dev/zero", true), 0u);
  EXPECT_EQ(images_of("gone.png", true), 0u);
  // A file from another machine, copied here together with its image.
  folder.write("meshes/near.png", "next to it");
  EXPECT_EQ(images_of("/home/somebody/project/near.png", false), 1u);
  EXPECT_EQ(images_of("C:\\Users\\somebody\\near.png", false), 1u);
}

TEST(MeshFiles, RefusalsNameTheFile) {
  const test::ScratchFolder folder;
  const auto refusal = [](const std::filesystem::path& file) {
    const Loaded loaded = load(file);
    if (loaded.surfaces) return std::string("read");
    EXPECT_NE(loaded.surfaces.error().message.find(file.filename().string()), std::string::npos)
        << loaded.surfaces.error().message;
    EXPECT_EQ(loaded.surfaces.error().message.find('\n'), std::string::npos);
    return loaded.surfaces.error().message;
  };
  const auto says = [](const std::string& message, const char* what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  says(refusal(folder.path() / "gone.obj"), "No such file");
  says(refusal(folder.path()), "is a folder");
  says(refusal("/dev/zero"), "not a file on a disk");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.obj").c_str(), 0600), 0);
  says(refusal(folder.path() / "pipe.obj"), "not a regular file");
  says(refusal(folder.write("a.fbx", "anything")), ".obj, .stl, .ply, .3ds, .dae, .glb and .gltf");
  says(refusal(folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n")), "no triangle");
  refusal(folder.write("empty.stl", ""));
  says(refusal(folder.write("far.obj", "v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3\n")), "");
  EXPECT_NE(refusal(folder.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")), "read");
  EXPECT_NE(refusal(folder.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")), "read");
  // A node that contains itself. The importer works for the next file.
  std::string loop = test::kDae;
  loop.replace(loop.find("<instance_geometry"), 0, "<instance_node url=\"#n\"/>");
  Model model;
  MeshFiles files(model);
  EXPECT_FALSE(files.surfaces(folder.write("loop.dae", loop)));
  EXPECT_TRUE(files.surfaces(folder.write("sound.dae", test::kDae)));
}

// Truncated at any position, and with changed bytes: read or refused, and a read mesh is complete.
TEST(MeshFiles, DamagedFilesHarmNobody) {
  const test::ScratchFolder folder;
  folder.write("some colours.mtl", test::kMtl);
  const std::pair<const char*, std::string> seeds[] = {
      {"a.obj", test::kObj}, {"a.stl", test::kAsciiStl},         {"b.stl", test::binary_stl()},
      {"a.dae", test::kDae}, {"a.3ds", test::three_ds()},        {"c.stl", std::string(80, '\xff')},
      {"a.ply", test::kPly}, {"a.glb", test::glb("x", "OPAQUE")}};
  uint32_t random = 1;
  const auto next = [&] { return (random = random * 1664525 + 1013904223) >> 8; };
  size_t refused = 0, read = 0;
  // One importer for all files: it must work after each failure.
  Model model;
  MeshFiles files(model);
  for (const auto& [name, seed] : seeds) {
    for (size_t i = 0; i < 40; ++i) {
      std::string damaged = seed.substr(0, i % 2 == 0 ? seed.size() * i / 40 : seed.size());
      if (i % 2 == 1)
        for (size_t k = 0; k < 1 + i / 4; ++k) damaged[next() % damaged.size()] = static_cast<char>(next());
      const Result<std::vector<Surface>> surfaces =
          files.surfaces(folder.write(std::to_string(i) + name, damaged));
      if (!surfaces) {
        ++refused;
        EXPECT_EQ(surfaces.error().message.find('\n'), std::string::npos);
        continue;
      }
      ++read;
      for (const Surface& s : *surfaces) {
        ASSERT_LT(s.material, model.materials.size());
        for (const uint32_t index : s.indices) ASSERT_LT(index, s.positions.size());
        for (const glm::vec3& p : s.positions)
          ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      }
    }
  }
  EXPECT_GT(refused, 40u);
  EXPECT_GT(read, 20u);
}

}  // namespace
}  // namespace fire3dv::convert
