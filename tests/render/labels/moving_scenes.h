// Scenes and oracles of the tests of labels between two images: tubes that bend, and points carried by faces.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "renderer/scene/model/scene_edits.h"
#include "tests/render/labels/label_scenes.h"

namespace fire3dv::test {

// The point of a face that has the place of `point` on another: both have the same vertices.
inline glm::dvec3 carried(const Face& from, const Face& to, const glm::dvec3& point) {
  const glm::dvec3 ab = from.corner_world[1] - from.corner_world[0],
                   ac = from.corner_world[2] - from.corner_world[0], ap = point - from.corner_world[0];
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double area2 = glm::dot(normal, normal);
  const double b = glm::dot(glm::cross(ap, ac), normal) / area2,
               c = glm::dot(glm::cross(ab, ap), normal) / area2;
  return (1 - b - c) * to.corner_world[0] + b * to.corner_world[1] + c * to.corner_world[2];
}

// Compares each pixel's motion with faces before and now. Returns the number of compared pixels that moved.
inline size_t expect_motion(const std::vector<glm::vec2>& motion, const Eye& before, const Eye& now,
                            const std::vector<Face>& faces_before, const std::vector<Face>& faces_now,
                            double limit_px) {
  size_t moved = 0;
  double worst = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = y % 3; x < kLabelExtent.width; x += 3) {
      const auto hit = now.cast_surely(faces_now, {x, y});
      if (!hit || hit->instance == 0) continue;
      const glm::dvec3 point = carried(faces_now[hit->face], faces_before[hit->face], hit->point_world);
      const glm::dvec2 want = glm::dvec2(x, y) - before.project(point);
      const glm::dvec2 got(motion[size_t{y} * kLabelExtent.width + x]);
      worst = std::max(worst, glm::distance(want, got));
      EXPECT_LT(glm::distance(want, got), limit_px) << "at " << x << ", " << y;
      if (::testing::Test::HasFailure()) return 0;
      moved += glm::length(want) > 0.5 ? 1 : 0;
    }
  }
  ::testing::Test::RecordProperty("worst_px", std::to_string(worst));
  return moved;
}

// A tube along X whose axis is a sine of x that travels.
constexpr uint32_t kTubeRings = 40, kTubeSides = 12;
inline std::vector<glm::vec3> tube(double phase) {
  std::vector<glm::vec3> positions;
  for (uint32_t ring = 0; ring <= kTubeRings; ++ring) {
    const double x = 4.0 * ring / kTubeRings - 2;
    for (uint32_t side = 0; side < kTubeSides; ++side) {
      const double angle = 2 * M_PI * side / kTubeSides;
      positions.emplace_back(x, 0.4 * std::sin(2 * x + phase) + 0.3 * std::cos(angle), 0.3 * std::sin(angle));
    }
  }
  return positions;
}

// Two tubes with phases of their own.
constexpr uint32_t kFirstTube = 1, kSecondTube = 2;
inline scene::Scene tube_scene(double first_phase, double second_phase) {
  SceneBuilder builder;
  std::vector<uint32_t> indices;
  for (uint32_t ring = 0; ring < kTubeRings; ++ring) {
    for (uint32_t side = 0; side < kTubeSides; ++side) {
      const uint32_t next = (side + 1) % kTubeSides, a = ring * kTubeSides;
      for (const uint32_t i : {a + side, a + next, a + kTubeSides + side, a + next, a + kTubeSides + next,
                               a + kTubeSides + side})
        indices.push_back(i);
    }
  }
  scene::Material material = matte({0.8f, 0.4f, 0.3f});
  std::vector<scene::VertexAttributes> attributes((kTubeRings + 1) * kTubeSides);
  for (scene::VertexAttributes& attribute : attributes) attribute.normal = {0, 0, 1};
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.5f, 0.5f})), 3), at({0, -1.2f, 0}));
  builder.mesh_node("tube", builder.mesh(builder.material(material), tube(first_phase), attributes, indices),
                    glm::mat4(1));
  builder.mesh_node("second tube",
                    builder.mesh(builder.material(material), tube(second_phase), attributes, indices),
                    at({0.2f, 0.9f, -0.6f}));
  builder.camera_node("camera", {0, 0, 5}, {0, 0, 0});
  return builder.build();
}

// Streams the vertices of both tubes.
inline void stream_tubes(scene::SceneEdits& edits, const scene::Scene& scene, double first_phase,
                         double second_phase, bool second_is_hidden = false) {
  scene::NodeEdit first, second;
  first.vertices = std::make_shared<scene::ReplacedVertices>(scene::ReplacedVertices{tube(first_phase), {}});
  second.vertices =
      std::make_shared<scene::ReplacedVertices>(scene::ReplacedVertices{tube(second_phase), {}});
  second.hidden = second_is_hidden;
  edits.set(scene, {{kFirstTube, first}, {kSecondTube, second}});
}

inline scene::Scene streamed_tubes() {
  scene::Scene scene = tube_scene(0, 0);
  for (const uint32_t node : {kFirstTube, kSecondTube}) scene.nodes[node].has_instance_vertices = true;
  return scene;
}

}  // namespace fire3dv::test
