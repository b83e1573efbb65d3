// Test of shadow caster classification. A mesh wrongly classified as closed or planar loses its shadow in
// shadow maps; one wrongly classified as open only costs rays.
#include "renderer/scene/derived/loaded_scene.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/unit/renderer/scene/clusters/mesh_scenes.h"

namespace fire3dv::test {
namespace {

using scene::CasterShape;

scene::Caster caster(const Triangles& triangles, const scene::Material& material = {}) {
  scene::Scene scene;
  scene.materials.push_back(material);
  add_primitive(scene, triangles);
  add_mesh(scene);
  return scene::classify_caster(scene, scene.meshes[0]);
}

CasterShape shape(const Triangles& triangles, const scene::Material& material = {}) {
  return caster(triangles, material).shape;
}

Triangles quad() {
  return {{{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}}, {0, 1, 2, 0, 2, 3}};
}

TEST(CasterShape, SolidsAreClosed) {
  EXPECT_EQ(shape(box_triangles({1, 2, 3})), CasterShape::closed);  // three vertices at each corner
  EXPECT_EQ(shape(box_triangles({1e-4f, 1e-4f, 1e-4f})), CasterShape::closed);
  EXPECT_EQ(shape(ball_triangles(1, 32)), CasterShape::closed);
  EXPECT_EQ(shape(ball_triangles(1, 32, 0.3f)), CasterShape::closed);
}

TEST(CasterShape, PrimitivesFormOneSolid) {
  const Triangles box = box_triangles({1, 1, 1});
  Triangles half = box, other_half = box;
  half.indices.resize(18);
  other_half.indices.erase(other_half.indices.begin(), other_half.indices.begin() + 18);
  scene::Scene scene;
  add_primitive(scene, half);
  add_primitive(scene, {{{9, 9, 9}, {8, 8, 8}}, {0, 1}}, 0, scene::Topology::lines);  // lines bound no volume
  add_primitive(scene, other_half);
  add_mesh(scene);
  EXPECT_EQ(scene::classify_caster(scene, scene.meshes[0]).shape, CasterShape::closed);
}

TEST(CasterShape, SignOfZeroIsIgnored) {
  Triangles box = box_triangles({1, 1, 1});
  for (size_t i = 0; i < box.positions.size(); ++i) {
    glm::vec3& p = box.positions[i];
    p = glm::max(p, glm::vec3(0));
    if (i % 2) p = glm::vec3(p.x == 0 ? -0.0f : p.x, p.y == 0 ? -0.0f : p.y, p.z);
  }
  EXPECT_EQ(shape(box), CasterShape::closed);
}

TEST(CasterShape, DefectiveMeshIsOpen) {
  for (size_t missing = 0; missing < 36; missing += 3) {
    Triangles box = box_triangles({1, 1, 1});
    const auto first = box.indices.begin() + static_cast<std::ptrdiff_t>(missing);
    Triangles flipped = box, twice = box;
    std::swap(flipped.indices[missing], flipped.indices[missing + 1]);
    twice.indices.insert(twice.indices.end(),
                         {box.indices[missing], box.indices[missing + 1], box.indices[missing + 2]});
    box.indices.erase(first, first + 3);
    EXPECT_EQ(shape(box), CasterShape::open);
    EXPECT_EQ(shape(flipped), CasterShape::open);
    EXPECT_EQ(shape(twice), CasterShape::open);
  }
}

TEST(CasterShape, RoundedSeamsAreClosed) {
  Triangles box = box_triangles({1, 1, 1});
  box.positions[0].x = std::nextafter(box.positions[0].x, 2.0f);
  EXPECT_EQ(shape(box), CasterShape::closed);
  box.positions[0].x += 1e-4f;
  EXPECT_EQ(shape(box), CasterShape::open) << "a slit that light gets through";
  // A tube whose wall ends beside its start, with end caps; without one cap it stays open.
  Triangles tube;
  constexpr uint32_t kSides = 24;
  for (uint32_t k = 0; k <= kSides; ++k) {
    const float angle = 6.28318531f * static_cast<float>(k) / kSides;
    tube.positions.push_back({std::cos(angle), 0, std::sin(angle)});
    tube.positions.push_back({std::cos(angle), 2, std::sin(angle)});
  }
  tube.positions.push_back({0, 0, 0});
  tube.positions.push_back({0, 2, 0});
  const auto low_center = static_cast<uint32_t>(tube.positions.size() - 2), high_center = low_center + 1;
  ASSERT_NE(tube.positions[0], tube.positions[2 * kSides]);
  for (uint32_t k = 0; k < kSides; ++k) {
    const uint32_t a = 2 * k, b = a + 1, c = a + 2, d = a + 3;
    for (uint32_t index : {a, b, d, a, d, c, low_center, a, c, high_center, d, b})
      tube.indices.push_back(index);
  }
  EXPECT_EQ(shape(tube), CasterShape::closed);
  tube.indices.resize(tube.indices.size() - 3);
  EXPECT_EQ(shape(tube), CasterShape::open);
}

TEST(CasterShape, InsideOutIsOpen) {
  Triangles box = box_triangles({1, 1, 1});
  box.turn_inside_out();
  EXPECT_EQ(shape(box), CasterShape::open);
  Triangles far_off;  // far from the origin, where the sign of a volume depends on rounding
  far_off.add(box, {100, 200, 300});
  EXPECT_EQ(shape(far_off), CasterShape::open);
}

TEST(CasterShape, PiecesFaceOutwards) {
  Triangles two = box_triangles({1, 1, 1});
  two.add(box_triangles({0.5f, 0.5f, 0.5f}), {3, 0, 0});
  EXPECT_EQ(shape(two), CasterShape::closed);
  Triangles room = box_triangles({0.9f, 0.9f, 0.9f});  // smaller, so that the total volume is positive
  room.turn_inside_out();
  Triangles solid_and_room = box_triangles({1, 1, 1});
  solid_and_room.add(room, {3, 0, 0});
  EXPECT_EQ(shape(solid_and_room), CasterShape::open);
}

TEST(CasterShape, EmptyTrianglesAreIgnored) {
  Triangles box = box_triangles({1, 1, 1});
  box.indices.insert(box.indices.end(), {0, 0, 1, 2, 2, 2});
  EXPECT_EQ(shape(box), CasterShape::closed);
  EXPECT_EQ(shape({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {0, 1, 2}}), CasterShape::open);
  EXPECT_EQ(shape({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {0, 1, 2}}), CasterShape::open);
  EXPECT_EQ(shape({}), CasterShape::open);
}

TEST(CasterShape, MaskedAndBlendedAreOpen) {
  scene::Material masked, blended, glass;
  masked.alpha_mode = scene::AlphaMode::mask;
  blended.alpha_mode = scene::AlphaMode::blend;
  glass.transmission = 0.5f;
  for (const scene::Material& material : {masked, blended, glass}) {
    EXPECT_EQ(shape(box_triangles({1, 1, 1}), material), CasterShape::open);
    EXPECT_EQ(shape(quad(), material), CasterShape::open);
  }
}

TEST(CasterShape, FlatMeshHasItsPlane) {
  const scene::Caster flat = caster(quad());
  EXPECT_EQ(flat.shape, CasterShape::planar);
  EXPECT_NEAR(std::abs(flat.plane_node.y), 1, 1e-6);
  const glm::mat4 tilt = glm::rotate(glm::mat4(1), 0.7f, glm::normalize(glm::vec3(1, 2, 3)));
  Triangles tilted = quad();
  for (glm::vec3& p : tilted.positions) p = glm::vec3(tilt * glm::vec4(p * 7.0f + glm::vec3(5, 6, 7), 1));
  const scene::Caster plane = caster(tilted);
  ASSERT_EQ(plane.shape, CasterShape::planar);
  EXPECT_NEAR(glm::length(glm::vec3(plane.plane_node)), 1, 1e-6);
  for (const glm::vec3& p : tilted.positions) {
    EXPECT_NEAR(glm::dot(glm::vec3(plane.plane_node), p) + plane.plane_node.w, 0, 1e-5);
  }
  tilted.positions[0] += 1e-3f * glm::vec3(plane.plane_node);  // of a mesh 20 m wide
  EXPECT_EQ(shape(tilted), CasterShape::open);
}

TEST(CasterShape, BentPlanesAreOpen) {
  Triangles ribbon;
  for (uint32_t i = 0; i < 20; ++i) {
    const float t = 0.1f * static_cast<float>(i);
    ribbon.positions.emplace_back(t, t * t, -0.1f);
    ribbon.positions.emplace_back(t, t * t, 0.1f);
    if (i)
      ribbon.indices.insert(ribbon.indices.end(), {2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1});
  }
  EXPECT_EQ(shape(ribbon), CasterShape::open);
}

}  // namespace
}  // namespace fire3dv::test
