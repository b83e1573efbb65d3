// Render test of labels between two images, against closed forms: motion of streamed, skinned and morphed
// meshes, and occlusion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "renderer/scene/model/scene_edits.h"
#include "tests/render/labels/label_scenes.h"
#include "tests/render/support/bent_bar.h"

namespace fire3dv::test {
namespace {

class LabelsOfTwo : public ValidationIsSilent {};

// The point of a face that has the place of `point` on another: both have the same vertices.
glm::dvec3 carried(const Face& from, const Face& to, const glm::dvec3& point) {
  const glm::dvec3 ab = from.corner_world[1] - from.corner_world[0],
                   ac = from.corner_world[2] - from.corner_world[0], ap = point - from.corner_world[0];
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double area2 = glm::dot(normal, normal);
  const double b = glm::dot(glm::cross(ap, ac), normal) / area2,
               c = glm::dot(glm::cross(ab, ap), normal) / area2;
  return (1 - b - c) * to.corner_world[0] + b * to.corner_world[1] + c * to.corner_world[2];
}

// Compares each pixel's motion with faces before and now. Returns the number of compared pixels that moved.
size_t expect_motion(const std::vector<glm::vec2>& motion, const Eye& before, const Eye& now,
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
std::vector<glm::vec3> tube(double phase) {
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

scene::Scene tube_scene(double phase) {
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
  builder.mesh_node("tube", builder.mesh(builder.material(material), tube(phase), attributes, indices),
                    glm::mat4(1));
  builder.camera_node("camera", {0, 0, 5}, {0, 0, 0});
  return builder.build();
}

TEST_F(LabelsOfTwo, MotionOfStreamedVertices) {
  scene::Scene scene = tube_scene(0);
  constexpr uint32_t kTube = 1;
  scene.nodes[kTube].has_instance_vertices = true;
  const Eye before = eye_at({0.2f, 0.5f, 4.5f}, {0, 0, 0}), now = eye_at({0.3f, 0.6f, 4.4f}, {0.05f, 0, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  scene::SceneEdits edits;
  bench.renderer().set_edits(edits);
  const state::PoseState poses(scene);
  const wire::ImageOutputs outputs(wire::kMotion | wire::kInstanceU32);
  const auto show = [&](double phase) {
    scene::NodeEdit edit;
    edit.vertices = std::make_shared<scene::ReplacedVertices>(scene::ReplacedVertices{tube(phase), {}});
    edits.set(scene, {{kTube, edit}});
  };
  passes::CameraHistory history;
  show(0.3);
  for (const glm::vec2& motion :
       bench.take(poses, view_through(before), outputs, &history).plane<glm::vec2>(wire::kMotion))
    ASSERT_EQ(motion, glm::vec2(0));
  show(0.9);
  const auto motion = bench.take(poses, view_through(now), outputs, &history).plane<glm::vec2>(wire::kMotion);
  EXPECT_GT(expect_motion(motion, before, now, resting_faces(tube_scene(0.3)), resting_faces(tube_scene(0.9)),
                          0.01),
            150u);
  // The next image is of the same vertices: only the camera has moved.
  const auto still = bench.take(poses, view_through(now), outputs, &history).plane<glm::vec2>(wire::kMotion);
  for (const glm::vec2& motion_px : still) ASSERT_EQ(motion_px, glm::vec2(0));
}

TEST_F(LabelsOfTwo, MotionOfSkinnedArm) {
  BarPose first, second;
  first.bulge = 0.2f;
  second.world_from_root = at({0.1f, 0.05f, 0});
  second.root_from_tip = at({0, 1, 0}) * glm::rotate(glm::mat4(1), 0.5f, glm::vec3(0, 0, 1));
  first.root_from_tip = at({0, 1, 0}) * glm::rotate(glm::mat4(1), 0.2f, glm::vec3(0, 0, 1));
  second.bulge = 0.7f;
  const scene::Scene scene = skinned_bar(first);
  const Eye before = eye_at({1, 2.5f, 4.5f}, {0, 0.9f, 0}), now = eye_at({1.1f, 2.5f, 4.4f}, {0, 0.9f, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  passes::CameraHistory history;
  const wire::ImageOutputs outputs(wire::kMotion);
  bench.take(poses, view_through(before), outputs, &history);
  poses.set_rest(moved(scene, second));
  const auto motion = bench.take(poses, view_through(now), outputs, &history).plane<glm::vec2>(wire::kMotion);
  // Masked holes show what lies behind them, which the ray caster does not know: the lower half is compared.
  std::vector<Face> faces_before = resting_faces(computed_bar(first)),
                    faces_now = resting_faces(computed_bar(second));
  std::vector<glm::vec2> lower = motion;
  size_t moved_pixels = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = now.cast_surely(faces_now, {x, y});
      if (!hit || hit->instance == 0) continue;
      const glm::dvec3 point = carried(faces_now[hit->face], faces_before[hit->face], hit->point_world);
      const glm::dvec2 want = glm::dvec2(x, y) - before.project(point);
      const glm::dvec2 got(lower[size_t{y} * kLabelExtent.width + x]);
      if (glm::distance(want, got) < 0.01) {
        moved_pixels += glm::length(want) > 0.5 ? 1 : 0;
        continue;
      }
      // Above the tip's joint.
      ASSERT_GT(hit->point_world.y, 1.0) << "at " << x << ", " << y << ": " << got.x << ", " << got.y;
    }
  }
  EXPECT_GT(moved_pixels, 100u);
}

TEST_F(LabelsOfTwo, MotionOfMorphedMesh) {
  const scene::Scene scene = morphed_bar(0.1f);
  const Eye eye = eye_at({1, 1.5f, 4}, {0, 0.9f, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  passes::CameraHistory history;
  const wire::ImageOutputs outputs(wire::kMotion);
  bench.take(poses, view_through(eye), outputs, &history);
  state::RestPose rest = state::rest_pose(scene);
  rest.morph_weights = {1.0f};
  poses.set_rest(rest);
  const auto motion = bench.take(poses, view_through(eye), outputs, &history).plane<glm::vec2>(wire::kMotion);
  std::vector<Face> faces_before = resting_faces(computed_morphed_bar(0.1f)),
                    faces_now = resting_faces(computed_morphed_bar(1));
  // The node mirrors the mesh, and thus the winding of its faces.
  for (std::vector<Face>* const faces : {&faces_before, &faces_now})
    for (Face& face : *faces)
      if (scene.nodes[face.instance - 1].name == "bar") std::swap(face.corner_world[1], face.corner_world[2]);
  size_t moved_pixels = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = eye.cast_surely(faces_now, {x, y});
      if (!hit || hit->instance == 0 || hit->point_world.y > 1) continue;
      const glm::dvec3 point = carried(faces_now[hit->face], faces_before[hit->face], hit->point_world);
      const glm::dvec2 want = glm::dvec2(x, y) - eye.project(point);
      ASSERT_LT(glm::distance(want, glm::dvec2(motion[size_t{y} * kLabelExtent.width + x])), 0.01)
          << "at " << x << ", " << y;
      moved_pixels += glm::length(want) > 0.5 ? 1 : 0;
    }
  }
  EXPECT_GT(moved_pixels, 20u);
}

TEST_F(LabelsOfTwo, OcclusionByMovingPlate) {
  const scene::Scene scene = plate_and_wall();
  const Eye before = eye_at({0, 0, 4}, {0, 0, 0}), now = eye_at({0.3f, 0.1f, 4}, {0.2f, 0, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  passes::CameraHistory history;
  const wire::ImageOutputs outputs = wire::with_sources(wire::ImageOutputs(wire::kOcclusionU32));
  for (const uint32_t value :
       bench.take(poses, view_through(before), outputs, &history).plane<uint32_t>(wire::kOcclusionU32))
    ASSERT_EQ(value, 0u) << "in the first image";
  const std::vector<Face> faces_before = resting_faces(scene);
  std::vector<glm::mat4> moved_nodes;
  for (const scene::Node& node : scene.nodes) moved_nodes.push_back(node.world_from_node);
  moved_nodes[kPlate] = at({0.6f, 0.1f, 1});
  const std::vector<Face> faces_now = faces_of(scene, moved_nodes);
  state::RestPose rest = state::rest_pose(scene);
  rest.parent_from_node[kPlate] = rest.world_from_node[kPlate] = moved_nodes[kPlate];
  poses.set_rest(rest);
  const auto got =
      bench.take(poses, view_through(now), outputs, &history).plane<uint32_t>(wire::kOcclusionU32);
  size_t counts[3] = {};
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = now.cast_surely(faces_now, {x, y});
      if (!hit) continue;
      uint32_t want = 0;
      if (hit->instance != 0) {
        const glm::dvec3 point = carried(faces_now[hit->face], faces_before[hit->face], hit->point_world);
        const glm::dvec2 place = before.project(point), size(kLabelExtent.width, kLabelExtent.height);
        const glm::dvec2 from_edge = glm::min(place + 0.5, size - 0.5 - place);
        if (std::abs(std::min(from_edge.x, from_edge.y)) < 0.01) continue;
        if (std::min(from_edge.x, from_edge.y) < 0) {
          want = 2;
        } else {
          // Not where the last image has an edge within a pixel.
          const Hit last = before.cast(faces_before, place);
          bool is_certain = true;
          for (const glm::dvec2 aside :
               {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)})
            is_certain &= before.cast(faces_before, place + aside).instance == last.instance;
          if (!is_certain) continue;
          want = last.instance != hit->instance ? 1 : 0;
        }
      }
      ASSERT_EQ(got[size_t{y} * kLabelExtent.width + x], want) << "at " << x << ", " << y;
      ++counts[want];
    }
  }
  EXPECT_GT(counts[0], 3000u);
  EXPECT_GT(counts[1], 150u);
  EXPECT_GT(counts[2], 50u);
}

}  // namespace
}  // namespace fire3dv::test
