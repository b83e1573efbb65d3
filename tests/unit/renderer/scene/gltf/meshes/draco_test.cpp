// Test of KHR_draco_mesh_compression: streams of libdraco's encoder against their source, and damaged ones.
#include <dlfcn.h>
#include <draco/metadata/geometry_metadata.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <initializer_list>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/gltf/meshes/draco_header.h"
#include "renderer/scene/model/vertices.h"
#include "tests/unit/renderer/scene/gltf/loaded_scene.h"
#include "tests/unit/renderer/scene/gltf/meshes/draco_file.h"

namespace fire3dv::scene {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::SourceMesh;

constexpr int kMethods[] = {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING};

std::vector<std::byte> stream_of(const SourceMesh& source, int method) {
  return test::encoded(*test::draco_mesh(source), method);
}

json& primitive_of(GltfBuilder& builder) {
  return builder.root["meshes"][0]["primitives"][0];
}
json& extension_of(GltfBuilder& builder) {
  return primitive_of(builder)["extensions"]["KHR_draco_mesh_compression"];
}

// The source vertex with the nearest position.
size_t nearest(const SourceMesh& source, const glm::vec3& position) {
  size_t best = 0;
  for (size_t i = 1; i < source.positions.size(); ++i) {
    if (glm::distance(source.positions[i], position) < glm::distance(source.positions[best], position))
      best = i;
  }
  return best;
}

// Faces as source vertices, rotated so that the least comes first, in order.
using Faces = std::vector<std::array<uint32_t, 3>>;
Faces sorted(Faces faces) {
  for (auto& face : faces) std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  std::sort(faces.begin(), faces.end());
  return faces;
}

void expect_like(const SourceMesh& source, const Scene& scene) {
  ASSERT_EQ(scene.positions.size(), source.positions.size());
  std::vector<uint32_t> source_of(scene.positions.size());
  for (uint32_t v = 0; v < scene.positions.size(); ++v) {
    const size_t s = nearest(source, scene.positions[v]);
    source_of[v] = static_cast<uint32_t>(s);
    // Half a step of 14 bits over the largest extent, which is 1.
    EXPECT_LE(glm::distance(scene.positions[v], source.positions[s]), 1.0f / (1 << 14));
    const VertexAttributes vertex = attributes_of(scene, v);
    EXPECT_GT(glm::dot(glm::normalize(vertex.normal), source.normals[s]), 0.999999f);
    EXPECT_LE(glm::distance(vertex.uv0, source.uvs[s]), 1.0f / (1 << 12));
  }
  Faces faces;
  for (size_t i = 0; i < scene.indices.size(); i += 3) {
    faces.push_back(
        {source_of[scene.indices[i]], source_of[scene.indices[i + 1]], source_of[scene.indices[i + 2]]});
  }
  EXPECT_EQ(sorted(faces), sorted(source.faces));
}

TEST(SceneDraco, BothEncodingsMatchSource) {
  const SourceMesh source = test::bumpy_square(8);
  for (const int method : kMethods) {
    const Scene scene = loaded(test::draco_file(stream_of(source, method), source));
    EXPECT_TRUE(scene.warnings.empty());
    expect_like(source, scene);
  }
}

TEST(SceneDraco, AttributeSeamsSplitVertices) {
  SourceMesh source = test::bumpy_square(4);
  // A second copy of the middle column with other texture coordinates, for the faces on its right.
  std::vector<uint32_t> copy(source.positions.size(), kNone);
  for (auto& face : source.faces) {
    const bool right = std::any_of(face.begin(), face.end(), [&](uint32_t v) { return v % 5 > 2; });
    for (uint32_t& v : face) {
      if (!right || v >= copy.size() || v % 5 != 2) continue;
      if (copy[v] == kNone) {
        copy[v] = static_cast<uint32_t>(source.positions.size());
        source.positions.push_back(source.positions[v]);
        source.normals.push_back(source.normals[v]);
        source.uvs.push_back(source.uvs[v] + glm::vec2(0, 2));
      }
      v = copy[v];
    }
  }
  const auto mesh = test::draco_mesh(source);
  ASSERT_TRUE(mesh->DeduplicateAttributeValues());
  mesh->DeduplicatePointIds();
  const auto scene = loaded(test::draco_file(test::encoded(*mesh, draco::MESH_EDGEBREAKER_ENCODING), source));
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
  ASSERT_EQ(scene.positions.size(), source.positions.size());
  size_t shifted = 0;
  for (uint32_t v = 0; v < scene.positions.size(); ++v) shifted += attributes_of(scene, v).uv0.y > 1.5f;
  EXPECT_EQ(shifted, 5u);
}

TEST(SceneDraco, IntegersAreConverted) {
  SourceMesh source = test::bumpy_square(3);
  for (uint32_t v = 0; v < source.positions.size(); ++v) {
    const auto byte = static_cast<uint8_t>(v * 10);
    source.colors.push_back({byte, static_cast<uint8_t>(255 - byte), 51, 255});
    source.joints.push_back({static_cast<uint16_t>(v % 3), 1, 0, 0});
    source.weights.emplace_back(0.25f, 0.75f, 0, 0);
  }
  for (const bool as_floats : {false, true}) {
    GltfBuilder builder = test::draco_file(stream_of(source, draco::MESH_SEQUENTIAL_ENCODING), source);
    const auto color = primitive_of(builder)["attributes"]["COLOR_0"].get<size_t>();
    if (as_floats) {
      builder.root["accessors"][color]["componentType"] = test::kFloat;
      builder.root["accessors"][color].erase("normalized");
    }
    const Scene scene = loaded(builder);
    ASSERT_EQ(scene.influences.size(), source.positions.size());
    for (uint32_t v = 0; v < source.positions.size(); ++v) {
      const size_t s = nearest(source, scene.positions[v]);
      const glm::vec4 drawn = attributes_of(scene, v).color;
      for (int c = 0; c < 4; ++c)
        EXPECT_NEAR(drawn[c], source.colors[s][static_cast<size_t>(c)] / 255.0f, 1e-4f) << as_floats;
      EXPECT_EQ(scene.influences[v].joints, (std::array<uint16_t, 4>{source.joints[s][0], 1, 0, 0}));
      EXPECT_NEAR(scene.influences[v].weights[1], 0.75f, 1e-4f);
    }
  }
}

TEST(SceneDraco, MorphTargetsStayUncompressed) {
  const SourceMesh source = test::bumpy_square(3);
  GltfBuilder builder = test::draco_file(stream_of(source, draco::MESH_SEQUENTIAL_ENCODING), source);
  std::vector<float> deltas;
  for (size_t v = 0; v < source.positions.size(); ++v) {
    for (size_t c = 0; c < 3; ++c) deltas.push_back(c == 2 ? static_cast<float>(v) : 0);
  }
  primitive_of(builder)["targets"] = {{{"POSITION", builder.add_positions(deltas)}}};
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.morph_deltas.size(), source.positions.size());
  for (uint32_t v = 0; v < source.positions.size(); ++v)
    EXPECT_EQ(scene.morph_deltas[v].position.z, static_cast<float>(v));
}

TEST(SceneDraco, OtherAttributesUseAccessors) {
  const SourceMesh source = test::bumpy_square(2);
  GltfBuilder builder = test::draco_file(stream_of(source, draco::MESH_SEQUENTIAL_ENCODING), source);
  std::vector<float> colors(source.positions.size() * 3, 0.5f);
  primitive_of(builder)["attributes"]["COLOR_0"] = builder.add_data(colors, "VEC3", test::kFloat, 3);
  const Scene scene = loaded(builder);
  EXPECT_NEAR(attributes_of(scene, 4).color.g, 0.5f, 1e-4f);
}

TEST(SceneDraco, StreamSharesGeometry) {
  const SourceMesh source = test::bumpy_square(3);
  GltfBuilder builder = test::draco_file(stream_of(source, draco::MESH_EDGEBREAKER_ENCODING), source);
  json& primitives = builder.root["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  primitives[1]["mode"] = 4;
  const Scene scene = loaded(builder);
  ASSERT_EQ(scene.primitives.size(), 2u);
  EXPECT_EQ(scene.positions.size(), source.positions.size());
  EXPECT_EQ(scene.primitives[1].first_vertex, scene.primitives[0].first_vertex);
}

TEST(SceneDraco, MetadataAreSkipped) {
  const SourceMesh source = test::bumpy_square(3);
  const auto mesh = test::draco_mesh(source);
  auto metadata = std::make_unique<draco::GeometryMetadata>();
  metadata->AddEntryString("name", "square");
  auto nested = std::make_unique<draco::Metadata>();
  nested->AddEntryInt("number", 5);
  ASSERT_TRUE(metadata->AddSubMetadata("nested", std::move(nested)));
  mesh->AddMetadata(std::move(metadata));
  auto of_uvs = std::make_unique<draco::AttributeMetadata>();
  of_uvs->AddEntryInt("set", 0);
  mesh->AddAttributeMetadata(mesh->GetAttributeIdByUniqueId(test::kUvId), std::move(of_uvs));
  const Scene scene =
      loaded(test::draco_file(test::encoded(*mesh, draco::MESH_EDGEBREAKER_ENCODING), source));
  expect_like(source, scene);
}

TEST(SceneDraco, DamagedStreamNamesThePrimitive) {
  const SourceMesh source = test::bumpy_square(3);
  std::vector<std::byte> stream = stream_of(source, draco::MESH_EDGEBREAKER_ENCODING);
  stream.resize(stream.size() / 2);
  const auto scene = load(test::draco_file(stream, source));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: the "
                                       "Draco stream is damaged"),
            std::string::npos)
      << scene.error().message;
}

TEST(SceneDraco, DamagedStreamFallsBack) {
  const SourceMesh source = test::bumpy_square(3);
  std::vector<std::byte> stream = stream_of(source, draco::MESH_EDGEBREAKER_ENCODING);
  stream.resize(stream.size() / 2);
  GltfBuilder builder = test::draco_file(stream, source);
  builder.root.erase("extensionsRequired");
  json& attributes = primitive_of(builder)["attributes"];
  attributes.clear();
  attributes["POSITION"] = builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
  primitive_of(builder)["indices"] = builder.add_indices({0, 1, 2});
  extension_of(builder)["attributes"] = {{"POSITION", test::kPositionId}};
  const Scene scene = loaded(builder);
  EXPECT_EQ(scene.positions.size(), 3u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("meshes[0].primitives[0]"), std::string::npos) << scene.warnings[0];
  EXPECT_NE(scene.warnings[0].find("the uncompressed accessors are drawn"), std::string::npos);
}

TEST(SceneDraco, StreamPrecedesAccessors) {
  const SourceMesh source = test::bumpy_square(3);
  GltfBuilder builder = test::draco_file(stream_of(source, draco::MESH_EDGEBREAKER_ENCODING), source);
  const size_t zeros = builder.add_view(std::vector<std::byte>(source.positions.size() * 12));
  for (size_t i = 0; i < 4; ++i) builder.root["accessors"][i]["bufferView"] = zeros;
  expect_like(source, loaded(builder));
}

TEST(SceneDraco, CountsOfAccessorsBoundStream) {
  const SourceMesh source = test::bumpy_square(3);
  const auto error_with = [&](int method, const char* accessor, size_t count) {
    GltfBuilder builder = test::draco_file(stream_of(source, method), source);
    json& primitive = primitive_of(builder);
    const auto index = (primitive.contains(accessor) ? primitive : primitive["attributes"])[accessor];
    builder.root["accessors"][index.get<size_t>()]["count"] = count;
    const auto scene = load(builder);
    return scene ? "warning: " + (scene->warnings.empty() ? "none" : scene->warnings[0])
                 : scene.error().message;
  };
  for (const int method : kMethods) {
    EXPECT_NE(error_with(method, "indices", 51)
                  .find("states 18 triangles, but the accessor of the indices "
                        "has room for 17"),
              std::string::npos);
    // Exporters that state the size before compression.
    const std::string warning = error_with(method, "POSITION", 20);
    EXPECT_TRUE(warning.starts_with("warning: meshes[0].primitives[0]")) << warning;
    EXPECT_NE(warning.find("holds 16 vertices, but the accessor of POSITION states 20"), std::string::npos);
  }
  EXPECT_NE(error_with(draco::MESH_SEQUENTIAL_ENCODING, "POSITION", 15).find("states 16 vertices"),
            std::string::npos);
}

TEST(SceneDraco, ContradictionsAreErrors) {
  const SourceMesh source = test::bumpy_square(2);
  const auto stream = stream_of(source, draco::MESH_EDGEBREAKER_ENCODING);
  const auto error_after = [&](const std::function<void(GltfBuilder&)>& edit) {
    GltfBuilder builder = test::draco_file(stream, source);
    edit(builder);
    const auto scene = load(builder);
    return scene ? std::string("no error") : scene.error().message;
  };
  const auto expect_error = [&](const char* text, const std::function<void(GltfBuilder&)>& edit) {
    const std::string error = error_after(edit);
    EXPECT_NE(error.find(text), std::string::npos) << error;
  };
  expect_error("has no attribute 99", [](auto& b) { extension_of(b)["attributes"]["NORMAL"] = 99; });
  expect_error("NORMAL: attribute 2 of the Draco stream has 2 components, but the accessor's type has 3",
               [](auto& b) { extension_of(b)["attributes"]["NORMAL"] = test::kUvId; });
  expect_error("attributes.COLOR_0 is not an attribute of the primitive",
               [](auto& b) { extension_of(b)["attributes"]["COLOR_0"] = 1; });
  expect_error("attributes.POSITION is missing", [](auto& b) { extension_of(b).erase("attributes"); });
  expect_error("bufferView is missing", [](auto& b) { extension_of(b).erase("bufferView"); });
  expect_error("bufferViews[9]", [](auto& b) { extension_of(b)["bufferView"] = 9; });
  expect_error("has the mode 1", [](auto& b) { primitive_of(b)["mode"] = 1; });
  expect_error("accessors[77]", [](auto& b) { primitive_of(b)["indices"] = 77; });
  expect_error("do not begin with DRACO", [](auto& b) { b.bin[0] = std::byte{0}; });
  expect_error("Draco version 9.2 is not supported", [](auto& b) { b.bin[5] = std::byte{9}; });
  expect_error("point cloud", [](auto& b) { b.bin[7] = std::byte{0}; });
}

std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

// "DRACO", version 2.2, mesh, method, flags.
std::vector<std::byte> header_bytes(int method, std::initializer_list<int> rest) {
  std::vector<std::byte> bytes = bytes_of({'D', 'R', 'A', 'C', 'O', 2, 2, 1, method, 0, 0});
  const auto more = bytes_of(rest);
  bytes.insert(bytes.end(), more.begin(), more.end());
  return bytes;
}

TEST(SceneDraco, SizesAreCheckedFirst) {
  const SourceMesh source = test::bumpy_square(2);
  // 357913941 faces, with room for them in the accessors.
  for (const auto& stream : {header_bytes(1, {0, 0xff, 0xff, 0xff, 0x7f, 0xd5, 0xaa, 0xd5, 0xaa, 0x01, 0,
                                              0xd5, 0xaa, 0xd5, 0xaa, 0x01, 0}),
                             header_bytes(0, {0xd5, 0xaa, 0xd5, 0xaa, 0x01, 0xff, 0xff, 0xff, 0x7f, 0})}) {
    auto header = read_draco_header(stream);
    ASSERT_TRUE(header.ok()) << header.error().message;
    EXPECT_EQ(header->faces, 357913941u);
    GltfBuilder builder = test::draco_file(stream, source);
    for (json& accessor : builder.root["accessors"]) accessor["count"] = 1u << 30;
    LoadLimits limits;
    std::atomic<uint64_t> largest = 0;
    limits.reserve = [&](uint64_t bytes) -> Result<void> {
      if (bytes > largest) largest = bytes;
      return {};
    };
    const auto scene = load_glb(builder.glb(), "bomb", limits);
    ASSERT_FALSE(scene.ok());
    EXPECT_NE(scene.error().message.find("cannot hold so much geometry"), std::string::npos)
        << scene.error().message;
    EXPECT_LT(largest, 1u << 20);
  }
}

// libdraco exports an older tinygltf under the same names. It must not take the place of the right one.
TEST(SceneDraco, TinygltfCopiesAreDistinct) {
  Dl_info found{};
  const auto function = &tinygltf::TinyGLTF::LoadASCIIFromString;
  void* address = nullptr;
  std::memcpy(&address, &function, sizeof address);
  ASSERT_NE(dladdr(address, &found), 0);
  EXPECT_EQ(std::string(found.dli_fname).find("draco"), std::string::npos) << found.dli_fname;
}

// All cuts and single flipped bits of small streams: an error or a scene, within bounded memory.
TEST(SceneDraco, DamagedStreamsAreHarmless) {
  SourceMesh source = test::bumpy_square(3);
  for (uint32_t v = 0; v < source.positions.size(); ++v)
    source.colors.push_back({static_cast<uint8_t>(v), 1, 2, 3});
  for (const int method : kMethods) {
    const auto whole = stream_of(source, method);
    size_t loads = 0, errors = 0;
    const auto try_stream = [&](const std::vector<std::byte>& stream) {
      LoadLimits limits;
      std::atomic<uint64_t> taken = 0;
      limits.reserve = [&](uint64_t bytes) -> Result<void> {
        if ((taken += bytes) > (64u << 20)) return Error{"too much"};
        return {};
      };
      (load_glb(test::draco_file(stream, source).glb(), "damaged", limits) ? loads : errors) += 1;
      EXPECT_LE(taken, 64u << 20);
    };
    for (size_t length = 0; length < whole.size(); ++length) {
      if (length > 0) try_stream({whole.begin(), whole.begin() + static_cast<ptrdiff_t>(length)});
    }
    for (size_t bit = 0; bit < whole.size() * 8; ++bit) {
      auto stream = whole;
      stream[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
      try_stream(stream);
    }
    EXPECT_GT(errors, whole.size() / 2);
    EXPECT_GT(loads, 0u);  // flipped bits of values
  }
}

}  // namespace
}  // namespace fire3dv::scene
