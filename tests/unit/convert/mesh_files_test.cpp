// Test of the mesh file readers: the conventions of each format, refusals, and damaged files.
#include "tools/convert/mesh/mesh_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <glm/gtc/epsilon.hpp>

#include "tests/support/gltf_builder.h"
#include "tests/unit/convert/mesh_file_bytes.h"
#include "tools/convert/model.h"

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

TEST(MeshFiles, ObjHasItsMaterialsAndOnlyTriangles) {
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

TEST(MeshFiles, StlIsFlat) {
  const test::ScratchFolder folder;
  const Loaded text = load(folder.write("a.stl", test::kAsciiStl));
  ASSERT_TRUE(text.surfaces) << text.surfaces.error().message;
  ASSERT_EQ(triangles(*text.surfaces), 2u);
  EXPECT_EQ(text.surfaces->front().positions.size(), 4u);
  EXPECT_TRUE(text.surfaces->front().normals.empty());  // the loader generates flat normals
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

TEST(MeshFiles, AxesAreTheFilesOwnAndUnitsAreMetres) {
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

TEST(MeshFiles, ImagesStayInTheirFolders) {
  const test::ScratchFolder folder;
  namespace fs = std::filesystem;
  fs::create_directories(folder.path() / "meshes");
  fs::create_directories(folder.path() / "images");
  folder.write("images/secret.png", "outside");
  fs::create_symlink(folder.path() / "images/secret.png", folder.path() / "meshes/link.png");
  const auto images_of = [&](const std::string& name, bool allow) {
    folder.write("meshes/some colours.mtl", "newmtl red one\nKd 1 1 1\nmap_Kd " + name + "\n");
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
  says(refusal("/dev/zero"), "no file on a disk");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.obj").c_str(), 0600), 0);
  says(refusal(folder.path() / "pipe.obj"), "not a regular file");
  says(refusal(folder.write("a.fbx", "anything")), ".obj, .stl, .3ds and .dae");
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
      {"a.obj", test::kObj}, {"a.stl", test::kAsciiStl},  {"b.stl", test::binary_stl()},
      {"a.dae", test::kDae}, {"a.3ds", test::three_ds()}, {"c.stl", std::string(80, '\xff')}};
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
