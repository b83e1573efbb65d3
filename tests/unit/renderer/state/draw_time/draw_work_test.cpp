// Test of estimated work: elements count with the pixels that they cover inside the view.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/state/draw_time/draw_work.h"

namespace fire3dv::state {
namespace {

constexpr float kSide = 100;

// Orthographic: 2 x 2 metres fill the view.
const WorkView kView{glm::mat4(1), {kSide, kSide}};

wire::Marker marker(wire::MarkerKind kind, std::vector<std::array<float, 3>> positions, float width = 1) {
  wire::Marker marker;
  marker.kind = kind;
  marker.width = width;
  marker.positions = std::move(positions);
  return marker;
}

TEST(DrawWork, PointsCoverTheirSquares) {
  const DrawWork work =
      marker_work(marker(wire::MarkerKind::points, {{0, 0, 0}, {0.5f, 0, 0}}, 10), glm::mat4(1), kView);
  EXPECT_NEAR(work.fragments, 200, 1);
  EXPECT_GE(work.vertices, 6);
}

TEST(DrawWork, HugePointsCoverTheViewAndNoMore) {
  const DrawWork work = marker_work(
      marker(wire::MarkerKind::points, std::vector<std::array<float, 3>>(20'000), 1e6f), glm::mat4(1), kView);
  EXPECT_NEAR(work.fragments, 20'000.0 * kSide * kSide, 1);
}

TEST(DrawWork, LengthsScaleWithTheMarker) {
  wire::Marker points = marker(wire::MarkerKind::points, {{0, 0, 0}}, 0.2f);
  points.width_unit = wire::MarkerUnit::lengths;
  EXPECT_NEAR(marker_work(points, glm::mat4(1), kView).fragments, 100, 1);
  EXPECT_NEAR(marker_work(points, glm::scale(glm::mat4(1), glm::vec3(2)), kView).fragments, 400, 1);
}

TEST(DrawWork, OutsideTheViewNothingIsCovered) {
  EXPECT_EQ(marker_work(marker(wire::MarkerKind::points, {{9, 0, 0}}, 10), glm::mat4(1), kView).fragments, 0);
}

TEST(DrawWork, TrianglesCoverHalfOfTheirBoxes) {
  const DrawWork work = marker_work(
      marker(wire::MarkerKind::triangles, {{-50, -50, 0}, {50, -50, 0}, {0, 50, 0}}), glm::mat4(1), kView);
  EXPECT_NEAR(work.fragments, kSide * kSide / 2, 1);
}

TEST(DrawWork, TextsCountGlyphs) {
  wire::Marker texts = marker(wire::MarkerKind::texts, {{0, 0, 0}}, 10);
  texts.texts = {std::string(1000, 'W')};
  const DrawWork work = marker_work(texts, glm::mat4(1), kView);
  EXPECT_EQ(work.vertices, 6000);
  EXPECT_NEAR(work.fragments, 50'000, 1);
}

TEST(DrawWork, MeshesCountTrianglesAndPixels) {
  scene::Scene scene;
  scene.positions = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}};
  scene.indices = {0, 1, 2, 0, 1, 2};
  scene.primitives.push_back({.index_count = 6, .vertex_count = 3});
  scene.meshes.push_back({.primitive_count = 1});
  EXPECT_EQ(triangle_count(scene, scene.meshes[0]), 2u);
  const DrawWork work = mesh_work(scene, scene.meshes[0], glm::mat4(1), kView);
  EXPECT_EQ(work.vertices, 6);
  EXPECT_NEAR(work.fragments, kSide * kSide, 1);
  const DrawWork small = mesh_work(scene, scene.meshes[0], glm::scale(glm::mat4(1), glm::vec3(0.1f)), kView);
  EXPECT_NEAR(small.fragments, kSide * kSide / 100, 1);
}

}  // namespace
}  // namespace fire3dv::state
