// Render test of motion between two images, against closed forms: streamed, skinned and morphed meshes.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render/labels/moving_scenes.h"
#include "tests/render/support/bent_bar.h"

namespace fire3dv::test {
namespace {

class LabelsOfTwo : public ValidationIsSilent {};

TEST_F(LabelsOfTwo, MotionOfStreamedVertices) {
  const scene::Scene scene = streamed_tubes();
  const Eye before = eye_at({0.2f, 0.5f, 4.5f}, {0, 0, 0}), now = eye_at({0.3f, 0.6f, 4.4f}, {0.05f, 0, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  scene::SceneEdits edits;
  bench.renderer().set_edits(edits);
  const state::PoseState poses(scene);
  const wire::ImageOutputs outputs(wire::kMotion | wire::kInstanceU32);
  passes::CameraHistory history;
  stream_tubes(edits, scene, 0.3, 1.1);
  for (const glm::vec2& motion :
       bench.take(poses, view_through(before), outputs, &history).plane<glm::vec2>(wire::kMotion))
    ASSERT_EQ(motion, glm::vec2(0));
  stream_tubes(edits, scene, 0.9, 0.8);
  const Taken taken = bench.take(poses, view_through(now), outputs, &history);
  const auto motion = taken.plane<glm::vec2>(wire::kMotion);
  EXPECT_GT(expect_motion(motion, before, now, resting_faces(tube_scene(0.3, 1.1)),
                          resting_faces(tube_scene(0.9, 0.8)), 0.01),
            250u);
  const auto instances = taken.plane<uint32_t>(wire::kInstanceU32);
  for (const uint32_t node : {kFirstTube, kSecondTube})
    EXPECT_GT(std::ranges::count(instances, node + 1), 300) << "both tubes are compared";
  // The next image is of the same vertices: only the camera has moved.
  const auto still = bench.take(poses, view_through(now), outputs, &history).plane<glm::vec2>(wire::kMotion);
  for (const glm::vec2& motion_px : still) ASSERT_EQ(motion_px, glm::vec2(0));
}

// A mesh may have no primitives: nothing deforms then.
TEST_F(LabelsOfTwo, DeformedNodeWithoutPrimitives) {
  SceneBuilder builder;
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.5f, 0.5f})), 3), glm::mat4(1));
  builder.mesh_node("empty", scene::kNone, glm::mat4(1));
  builder.camera_node("camera", {0, 2, 5}, {0, 0, 0});
  scene::Scene scene = builder.build();
  scene.meshes.push_back({"empty", static_cast<uint32_t>(scene.primitives.size()), 0});
  scene.nodes[1].mesh = static_cast<uint32_t>(scene.meshes.size() - 1);
  scene.nodes[1].has_instance_vertices = true;
  RenderBench bench(scene, kLabelExtent, plain());
  const state::PoseState poses(scene);
  passes::CameraHistory history;
  const Eye before = eye_at({0, 2, 5}, {0, 0, 0}), now = eye_at({0.2f, 2, 5}, {0, 0, 0});
  const wire::ImageOutputs outputs(wire::kMotion);
  bench.take(poses, view_through(before), outputs, &history);
  const auto motion = bench.take(poses, view_through(now), outputs, &history).plane<glm::vec2>(wire::kMotion);
  EXPECT_GT(expect_motion(motion, before, now, resting_faces(scene), resting_faces(scene), 0.01), 500u);
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
  size_t moved_pixels = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = now.cast_surely(faces_now, {x, y});
      if (!hit || hit->instance == 0) continue;
      const glm::dvec3 point = carried(faces_now[hit->face], faces_before[hit->face], hit->point_world);
      const glm::dvec2 want = glm::dvec2(x, y) - before.project(point);
      const glm::dvec2 got(motion[size_t{y} * kLabelExtent.width + x]);
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

}  // namespace
}  // namespace fire3dv::test
