// Test of tangent generation (MikkTSpace conventions): closed-form small meshes, and models with their own
// tangents as the reference.
#include "renderer/scene/model/vertices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <numbers>
#include <random>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/asset_collection_folder.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;

struct List {
  Vertices vertices;
  std::vector<uint32_t> indices;

  uint32_t add(glm::vec3 position, glm::vec2 uv, glm::vec3 normal = {0, 0, 1}) {
    vertices.positions.push_back(position);
    vertices.attributes.push_back({.uv0 = uv, .normal = normal});
    return static_cast<uint32_t>(vertices.positions.size() - 1);
  }
  const glm::vec4& tangent(size_t corner) const { return vertices.attributes[indices[corner]].tangent; }
};

double degrees_between(const glm::vec3& a, const glm::vec3& b) {
  const double cosine = glm::dot(a, b) / std::max(glm::length(a) * glm::length(b), 1e-30f);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

void expect_frames(const List& list) {
  for (size_t corner = 0; corner < list.indices.size(); ++corner) {
    const VertexAttributes& vertex = list.vertices.attributes[list.indices[corner]];
    ASSERT_NEAR(glm::length(glm::vec3(vertex.tangent)), 1, 1e-5) << corner;
    ASSERT_NEAR(glm::dot(glm::vec3(vertex.tangent), vertex.normal), 0, 1e-5) << corner;
    ASSERT_EQ(std::abs(vertex.tangent.w), 1) << corner;
  }
}

// A square with u to the right and v down, as in images.
List square() {
  List list;
  list.add({0, 0, 0}, {0, 1});
  list.add({1, 0, 0}, {1, 1});
  list.add({0, 1, 0}, {0, 0});
  list.add({1, 1, 0}, {1, 0});
  list.indices = {0, 1, 2, 2, 1, 3};
  return list;
}

TEST(SceneTangents, UprightImageIsNotMirrored) {
  List list = square();
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.positions.size(), 4u);
  for (size_t corner = 0; corner < 6; ++corner) EXPECT_EQ(list.tangent(corner), glm::vec4(1, 0, 0, 1));
}

TEST(SceneTangents, TheSecondSetOfCoordinates) {
  List list = square();
  for (VertexAttributes& vertex : list.vertices.attributes) vertex.uv1 = {vertex.uv0.y, vertex.uv0.x};
  generate_tangents(list.vertices, list.indices, 1);
  for (size_t corner = 0; corner < 6; ++corner) EXPECT_EQ(list.tangent(corner), glm::vec4(0, -1, 0, -1));
}

// Two adjacent squares; u rises to the common edge and falls again.
List butterfly() {
  List list;
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 2; ++row) list.add({column, row, 0}, {column == 1 ? 1 : 0, 1 - row});
  }
  list.indices = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
  return list;
}

TEST(SceneTangents, MirroredHalvesAreSplit) {
  List list = butterfly();
  const List before = list;
  generate_tangents(list.vertices, list.indices, 0);
  for (size_t corner = 0; corner < 6; ++corner) EXPECT_EQ(list.tangent(corner), glm::vec4(1, 0, 0, 1));
  for (size_t corner = 6; corner < 12; ++corner) EXPECT_EQ(list.tangent(corner), glm::vec4(-1, 0, 0, -1));
  // Vertices 2 and 3 are duplicated; a copy has equal attributes, and `source` refers to its original.
  ASSERT_EQ(list.vertices.positions.size(), 8u);
  EXPECT_EQ(list.vertices.source, (std::vector<uint32_t>{0, 1, 2, 3, 4, 5, 2, 3}));
  for (size_t corner = 0; corner < 12; ++corner) {
    const uint32_t now = list.indices[corner], then = before.indices[corner];
    EXPECT_EQ(list.vertices.source[now], then);
    EXPECT_EQ(list.vertices.positions[now], before.vertices.positions[then]);
    EXPECT_EQ(list.vertices.attributes[now].uv0, before.vertices.attributes[then].uv0);
  }
}

TEST(SceneTangents, EqualVerticesShareAFrame) {
  // A roof: two squares at an angle, with one normal along the ridge.
  List shared;
  const glm::vec3 up(0, 0, 1), left = glm::normalize(glm::vec3(-1, 0, 1)),
                               right = glm::normalize(glm::vec3(1, 0, 1));
  shared.add({-1, 0, 0}, {0, 1}, left);
  shared.add({-1, 1, 0}, {0, 0}, left);
  shared.add({0, 0, 1}, {1, 1}, up);
  shared.add({0, 1, 1}, {1, 0}, up);
  shared.add({1, 0, 0}, {2, 1}, right);
  shared.add({1, 1, 0}, {2, 0}, right);
  shared.indices = {0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5};
  List apart;
  for (const uint32_t index : shared.indices) {
    const VertexAttributes& vertex = shared.vertices.attributes[index];
    apart.indices.push_back(apart.add(shared.vertices.positions[index], vertex.uv0, vertex.normal));
  }
  generate_tangents(shared.vertices, shared.indices, 0);
  generate_tangents(apart.vertices, apart.indices, 0);
  EXPECT_EQ(shared.vertices.positions.size(), 6u);
  for (size_t corner = 0; corner < 12; ++corner)
    EXPECT_EQ(shared.tangent(corner), apart.tangent(corner)) << corner;
  EXPECT_EQ(shared.vertices.attributes[2].tangent, glm::vec4(1, 0, 0, 1));
  expect_frames(shared);
}

TEST(SceneTangents, TouchingTrianglesStaySeparate) {
  // Triangles around one vertex without common edges; u rotates with the triangle.
  List list;
  const uint32_t centre = list.add({0, 0, 0}, {0, 0});
  for (int i = 0; i < 2; ++i) {
    const float turn = i == 0 ? 1.0f : -1.0f;
    const uint32_t a = list.add({turn, 0, 0}, {1, 0}), b = list.add({0, turn, 0}, {0, -1});
    list.indices.insert(list.indices.end(), {centre, a, b});
  }
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.positions.size(), 6u);
  EXPECT_EQ(list.tangent(0), glm::vec4(1, 0, 0, 1));
  EXPECT_EQ(list.tangent(3), glm::vec4(-1, 0, 0, 1));
}

TEST(SceneTangents, AngleIsTheWeight) {
  // At vertex 0 meet a 90 degree corner with u along (1, 1), and a 45 degree corner with (4, 1).
  List list;
  list.add({0, 0, 0}, {0, 0});
  list.add({0, -1, 0}, {0, 1});
  list.add({1, 0, 0}, {1, 1});
  list.add({1, 1, 0}, {1, -3});
  list.indices = {0, 1, 2, 0, 2, 3};
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.positions.size(), 4u);
  const glm::vec3 expected = 2.0f * glm::normalize(glm::vec3(1, 1, 0)) + glm::normalize(glm::vec3(4, 1, 0));
  EXPECT_LT(degrees_between(glm::vec3(list.tangent(0)), expected), 0.01);
  EXPECT_LT(degrees_between(glm::vec3(list.tangent(1)), glm::vec3(1, 1, 0)), 0.01);
  EXPECT_LT(degrees_between(glm::vec3(list.tangent(5)), glm::vec3(4, 1, 0)), 0.01);
}

// Latitudes and longitudes; u runs around. The seam has its own vertices, and each pole has one per
// longitude.
List sphere(int columns, int rows) {
  List list;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const float u = static_cast<float>(column) / static_cast<float>(columns),
                  v = static_cast<float>(row) / static_cast<float>(rows);
      const float around = u * 2 * std::numbers::pi_v<float>, down = v * std::numbers::pi_v<float>;
      const float ring = row == 0 || row == rows ? 0.0f : std::sin(down);
      const glm::vec3 normal(ring * std::sin(around), std::cos(down), ring * std::cos(around));
      list.add(normal * 0.002f, {u, v}, normal);
    }
  }
  const auto at = [&](int row, int column) { return static_cast<uint32_t>(row * (columns + 1) + column); };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      for (const auto& [r, c] : {std::pair{row, column}, {row + 1, column}, {row, column + 1}})
        list.indices.push_back(at(r, c));
      for (const auto& [r, c] : {std::pair{row, column + 1}, {row + 1, column}, {row + 1, column + 1}})
        list.indices.push_back(at(r, c));
    }
  }
  return list;
}

TEST(SceneTangents, SphereTangentsFollowLatitudes) {
  List list = sphere(64, 32);
  generate_tangents(list.vertices, list.indices, 0);
  expect_frames(list);
  size_t corners = 0;
  double worst = 0;
  for (const uint32_t index : list.indices) {
    const glm::vec3& normal = list.vertices.attributes[index].normal;
    if (std::abs(normal.y) > 0.9999f) continue;  // no direction at the poles
    const glm::vec3 along(normal.z, 0, -normal.x);
    // At the seam only one side contributes: an error of half a longitude, 360 / 64 / 2 degrees.
    worst = std::max(worst, degrees_between(glm::vec3(list.vertices.attributes[index].tangent), along));
    EXPECT_EQ(list.vertices.attributes[index].tangent.w, 1);
    ++corners;
  }
  EXPECT_EQ(corners, 11904u);
  EXPECT_LT(worst, 2.82);
}

TEST(SceneTangents, TriangleOrderIsIrrelevant) {
  List list = sphere(24, 12), shuffled = list;
  std::mt19937 random(7);
  std::vector<uint32_t> order(list.indices.size() / 3);
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), random);
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) shuffled.indices[i * 3 + c] = list.indices[order[i] * 3 + c];
  }
  generate_tangents(list.vertices, list.indices, 0);
  generate_tangents(shuffled.vertices, shuffled.indices, 0);
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const glm::vec4 &a = list.tangent(order[i] * 3 + c), &b = shuffled.tangent(i * 3 + c);
      ASSERT_LT(degrees_between(glm::vec3(a), glm::vec3(b)), 0.1);
      ASSERT_EQ(a.w, b.w);
    }
  }
}

TEST(SceneTangents, CollapsedTrianglesUseNeighbours) {
  List list = square();
  const uint32_t flat = list.add({2, 0, 0}, {1, 1});            // its triangle has no area in texture space
  list.indices.insert(list.indices.end(), {0, 0, 1, 1, 3, 1});  // degenerate triangles
  list.indices.insert(list.indices.end(), {3, 1, flat});
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.positions.size(), 5u);
  for (size_t corner = 0; corner < 14; ++corner)
    EXPECT_EQ(list.tangent(corner), glm::vec4(1, 0, 0, 1)) << corner;
  expect_frames(list);
}

TEST(SceneTangents, UndecidedTriangleTakesOneHalf) {
  List list = butterfly();
  // A sliver without area in texture space along the common edge, between the halves.
  const uint32_t tip = list.add({1, 0.5f, 1}, {1, 0.5f});
  list.indices = {0, 2, 1, 1, 2, 3, 3, 2, tip, tip, 2, 4, 3, tip, 5};
  generate_tangents(list.vertices, list.indices, 0);
  expect_frames(list);
  EXPECT_EQ(list.tangent(0).w, 1);
  EXPECT_EQ(list.tangent(11).w, -1);
}

TEST(SceneTangents, MissingCoordinatesUseAny) {
  List list = square();
  for (VertexAttributes& vertex : list.vertices.attributes) vertex.uv0 = glm::vec2(0.5f);
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.positions.size(), 4u);
  expect_frames(list);
}

TEST(SceneTangents, ExtremeNumbersStayNumbers) {
  for (const float scale : {1e-30f, 1e30f}) {
    List list = square();
    for (glm::vec3& position : list.vertices.positions) position *= scale;
    for (VertexAttributes& vertex : list.vertices.attributes) vertex.uv0 *= scale;
    generate_tangents(list.vertices, list.indices, 0);
    expect_frames(list);
  }
}

TEST(SceneTangents, HugeFanIsFast) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> anywhere(-1, 1);
  List fan, book;
  fan.add({0, 0, 0}, {0, 0});
  book.add({0, 0, 0}, {0, 0});
  book.add({0, 0, 1}, {0, 1}, {1, 0, 0});
  for (int i = 0; i < 100000; ++i) {
    const auto point = [&](List& list) {
      return list.add({anywhere(random), anywhere(random), 0}, {anywhere(random), anywhere(random)});
    };
    const uint32_t a = point(fan), b = point(fan);
    fan.indices.insert(fan.indices.end(), {0, a, b});
    book.indices.insert(book.indices.end(), {0, 1, point(book)});
  }
  generate_tangents(fan.vertices, fan.indices, 0);
  generate_tangents(book.vertices, book.indices, 0);
  expect_frames(fan);
  EXPECT_GT(fan.vertices.positions.size(), 290000u);
  EXPECT_GT(book.vertices.positions.size(), 290000u);
}

TEST(SceneTangents, OfTrianglesWithoutNormals) {
  List list = butterfly();
  list.vertices.positions[4].z = list.vertices.positions[5].z = 1;
  make_flat(list.vertices, list.indices);
  generate_tangents(list.vertices, list.indices, 0);
  EXPECT_EQ(list.vertices.source, (std::vector<uint32_t>{0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5}));
  expect_frames(list);
}

// Copies would double the memory of a large mesh while it is loaded.
TEST(SceneVertices, TrianglesWithoutSharedVerticesAreNotCopied) {
  Vertices vertices;
  vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  vertices.attributes.resize(vertices.positions.size());
  const glm::vec3* const before = vertices.positions.data();
  std::vector<uint32_t> indices = {0, 1, 2, 3, 4, 5};
  make_flat(vertices, indices);
  EXPECT_EQ(vertices.positions.data(), before);
  EXPECT_TRUE(vertices.source.empty()) << "identity";
  EXPECT_EQ(vertices.attributes[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(vertices.attributes[5].normal, glm::vec3(1, 0, 0));
  indices = {0, 1, 2, 0, 2, 5};
  make_flat(vertices, indices);
  EXPECT_EQ(vertices.source, (std::vector<uint32_t>{0, 1, 2, 0, 2, 5}));
}

TEST(SceneTangents, TangentsAreOnDemand) {
  const auto load = [](const char* normal_texture, bool with_normals, bool with_tangents) {
    test::GltfBuilder builder;
    builder.add_textured_material(test::png(1, 1, 0xffff8080));
    if (normal_texture == std::string("normalTexture"))
      builder.root["materials"][0]["normalTexture"] = {{"index", 0}};
    if (normal_texture == std::string("clearcoat"))
      builder.root["materials"][0]["extensions"]["KHR_materials_clearcoat"] = {
          {"clearcoatNormalTexture", {{"index", 0}}}};
    if (normal_texture == std::string("anisotropy"))
      builder.root["materials"][0]["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 0.5}};
    nlohmann::json attributes{{"POSITION", builder.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}};
    attributes["TEXCOORD_0"] = builder.add_data<float>({0, 0, 0, 1, 1, 0}, "VEC2", test::kFloat, 2);
    if (with_normals) attributes["NORMAL"] = builder.add_positions({0, 0, 1, 0, 0, 1, 0, 0, 1});
    if (with_tangents)
      attributes["TANGENT"] =
          builder.add_data<float>({-1, 0, 0, 1, -1, 0, 0, 1, -1, 0, 0, 1}, "VEC4", test::kFloat, 4);
    builder.add_mesh({{"attributes", attributes}, {"material", 0}});
    const test::ScratchFolder folder;
    auto scene = load_gltf(folder.write("scene.glb", builder.glb()));
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return scene ? tangent_of(*scene, 0) : glm::vec4(0);
  };
  const glm::vec4 generated(0, 1, 0, 1), given(-1, 0, 0, 1), untouched = VertexAttributes().tangent;
  EXPECT_EQ(load("normalTexture", true, false), generated);
  EXPECT_EQ(load("clearcoat", true, false), generated);
  EXPECT_EQ(load("anisotropy", true, false), generated);
  EXPECT_EQ(load("anisotropy", true, true), given);
  EXPECT_EQ(load("normalTexture", true, true), given);
  EXPECT_EQ(load("normalTexture", false, true), generated);  // the file's are ignored without normals
  EXPECT_EQ(load("none", true, false), untouched);
}

struct Agreement {
  size_t corners = 0, within_1 = 0, within_5 = 0, same_sign = 0;
};

// Compares generated tangents with the file's, except for vertices without a direction of u.
Agreement agreement(const Scene& scene) {
  Agreement result;
  for (const Primitive& primitive : scene.primitives) {
    if (primitive.topology != Topology::triangles) continue;
    List list;
    const auto first = scene.positions.begin() + primitive.first_vertex;
    const auto first_index = scene.indices.begin() + primitive.first_index;
    list.vertices.positions.assign(first, first + primitive.vertex_count);
    for (uint32_t v = 0; v < primitive.vertex_count; ++v)
      list.vertices.attributes.push_back(attributes_of(scene, primitive.first_vertex + v));
    list.indices.assign(first_index, first_index + primitive.index_count);
    const List given = list;
    generate_tangents(list.vertices, list.indices, 0);
    for (size_t corner = 0; corner < list.indices.size(); ++corner) {
      const size_t triangle = corner / 3 * 3;
      const auto uv = [&](size_t c) { return given.vertices.attributes[given.indices[triangle + c]].uv0; };
      const glm::vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
      if (a.x * b.y == a.y * b.x) continue;
      const double degrees =
          degrees_between(glm::vec3(given.tangent(corner)), glm::vec3(list.tangent(corner)));
      ++result.corners;
      result.within_1 += degrees < 1;
      result.within_5 += degrees < 5;
      result.same_sign += given.tangent(corner).w == list.tangent(corner).w;
    }
  }
  return result;
}

// The comparison itself, with a sphere's tangents, which are known.
TEST(SceneTangents, GeneratedAgreeWithThemselves) {
  List list = sphere(64, 32);
  generate_tangents(list.vertices, list.indices, 0);
  Scene scene;
  scene.positions = list.vertices.positions;
  append_attributes(scene, list.vertices.attributes);
  scene.indices = list.indices;
  scene.primitives.push_back({.index_count = static_cast<uint32_t>(list.indices.size()),
                              .vertex_count = static_cast<uint32_t>(list.vertices.positions.size())});
  EXPECT_EQ(agreement(scene).within_1, list.indices.size());
}

// Blender derives tangents from quads before triangulation: bent quads differ by some degrees. The exporter
// of the older Khronos models uses v downwards, with inverted signs, which glTF now forbids. Suzanne's
// directions use another average.
TEST(SceneTangents, CollectionBringsTheSame) {
  FIRE3DV_NEEDS_ASSETS();
  struct Model {
    const char* file;
    double within_1, within_5, same_sign;  // minimum fractions of the vertices
  };
  const std::vector<Model> models{
      {"khronos-sample-models/Cube/glTF/Cube.gltf", 1, 1, 0},
      {"khronos-sample-models/TwoSidedPlane/glTF/TwoSidedPlane.gltf", 1, 1, 0},
      {"gltf-blender-io/01_plane/01_plane.gltf", 1, 1, 1},
      {"gltf-blender-io/01_cube/01_cube.gltf", 1, 1, 1},
      {"gltf-blender-io/04_lenna/04_lenna.gltf", 1, 1, 1},
      {"gltf-blender-io/01_sphere/01_sphere.gltf", 0.47, 0.97, 1},
      {"gltf-blender-io/01_metallic_sphere/01_metallic_sphere.gltf", 0.9, 0.99, 0.998},
      {"gltf-blender-io/02_node_hierarchy/02_node_hierarchy.gltf", 0.85, 0.95, 1},
      {"gltf-blender-io/04_common_materials/04_common_materials.gltf", 0.9, 0.99, 0.998},
      {"gltf-blender-io/05_node_material/05_node_material.gltf", 0.9, 0.99, 0.998},
      {"gltf-blender-io/24_animation_pointer/24_animation_pointer.gltf", 0.9, 0.94, 0.93},
  };
  for (const Model& model : models) {
    const auto scene = load_gltf(test::asset_collection_folder() / model.file);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const Agreement found = agreement(*scene);
    const double all = static_cast<double>(found.corners);
    std::cout << model.file << ": of " << found.corners << " corners "
              << 100 * static_cast<double>(found.within_1) / all << " % within 1 degree, "
              << 100 * static_cast<double>(found.within_5) / all << " % within 5, "
              << 100 * static_cast<double>(found.same_sign) / all << " % of the same sign\n";
    EXPECT_GE(static_cast<double>(found.within_1) / all, model.within_1) << model.file;
    EXPECT_GE(static_cast<double>(found.within_5) / all, model.within_5) << model.file;
    EXPECT_GE(static_cast<double>(found.same_sign) / all, model.same_sign) << model.file;
    EXPECT_EQ(model.same_sign == 0, found.same_sign == 0) << model.file;
  }
}

}  // namespace
}  // namespace fire3dv::scene
