// Render test of occlusion between two images, against closed forms, and of the memory of histories.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render/labels/moving_scenes.h"

namespace fire3dv::test {
namespace {

class Occlusion : public ValidationIsSilent {};

// Nodes that the last image had hidden were not seen, and have no motion.
TEST_F(Occlusion, HiddenNodesWereNotSeen) {
  const scene::Scene scene = streamed_tubes();
  const Eye eye = eye_at({0.2f, 0.5f, 4.5f}, {0, 0, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  scene::SceneEdits edits;
  bench.renderer().set_edits(edits);
  const state::PoseState poses(scene);
  const auto outputs =
      wire::with_sources(wire::ImageOutputs(wire::kMotion | wire::kInstanceU32 | wire::kOcclusionU32));
  passes::CameraHistory history;
  for (const bool is_streamed : {true, false}) {
    SCOPED_TRACE(is_streamed ? "a node with streamed vertices" : "a rigid node");
    const uint32_t hidden_node = is_streamed ? kSecondTube : 0;
    const auto set = [&](bool hides) {
      stream_tubes(edits, scene, 0.3, 1.1, hides && is_streamed);
      if (!is_streamed && hides) edits.change(scene, {{0, scene::NodeEdit{.hidden = true}}});
    };
    history = {};
    set(true);
    bench.take(poses, view_through(eye), outputs, &history);
    set(false);
    const Taken taken = bench.take(poses, view_through(eye), outputs, &history);
    const auto instances = taken.plane<uint32_t>(wire::kInstanceU32),
               occlusion = taken.plane<uint32_t>(wire::kOcclusionU32);
    const auto motion = taken.plane<glm::vec2>(wire::kMotion);
    size_t shown = 0;
    for (size_t i = 0; i < instances.size(); ++i) {
      const bool was_hidden = instances[i] == hidden_node + 1;
      shown += was_hidden ? 1 : 0;
      ASSERT_EQ(occlusion[i], was_hidden ? 1u : 0u) << i;
      ASSERT_EQ(std::isnan(motion[i].x), was_hidden) << i;
    }
    EXPECT_GT(shown, 300u);
  }
}

TEST_F(Occlusion, OcclusionByMovingPlate) {
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

// The place of a point in pixels, and its depth, as an orthographic camera sees it.
struct FlatEye {
  scene::Camera camera;
  glm::mat4 world_from_camera;

  passes::View view() const {
    return passes::make_view(camera, world_from_camera,
                             static_cast<float>(kLabelExtent.width) / kLabelExtent.height);
  }
};

FlatEye flat_eye_at(glm::vec3 place, glm::vec3 target) {
  FlatEye eye;
  eye.camera.orthographic = true;
  eye.camera.half_extent_m = {1.6f, 1.2f};
  eye.camera.near_m = 0.1f;
  eye.camera.far_m = 20;
  eye.world_from_camera = passes::look_at_pose(place, target);
  return eye;
}

// A slanted wall that an orthographic camera passes by parts of a pixel: all of it was seen, or was outside.
TEST_F(Occlusion, OcclusionThroughOrthographicCamera) {
  SceneBuilder builder;
  builder.mesh_node("wall", builder.quad(builder.material(matte({0.5f, 0.5f, 0.5f})), 30), glm::mat4(1));
  builder.mesh_node("plate", builder.box(builder.material(matte({0.5f, 0.2f, 0.2f})), {0.4f, 0.05f, 0.4f}),
                    at({0, 1, 0}));
  builder.camera_node("camera", {0, 0, 5}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  const auto outputs =
      wire::with_sources(wire::ImageOutputs(wire::kOcclusionU32 | wire::kInstanceU32 | wire::kPositionF32));
  const FlatEye before = flat_eye_at({0, 3, 5}, {0, 0, 0}), now = flat_eye_at({0.217f, 3, 5}, {0.217f, 0, 0});
  passes::CameraHistory history;
  bench.take(poses, before.view(), outputs, &history);
  // The plate rises to where it hides nothing.
  state::RestPose rest = state::rest_pose(scene);
  rest.parent_from_node[1] = rest.world_from_node[1] = at({0, 9, 0});
  poses.set_rest(rest);
  const Taken taken = bench.take(poses, now.view(), outputs, &history);
  const auto occlusion = taken.plane<uint32_t>(wire::kOcclusionU32);
  const auto position = taken.plane<glm::vec4>(wire::kPositionF32);
  const glm::dmat4 camera_from_world = glm::inverse(glm::dmat4(before.world_from_camera));
  const glm::dvec3 towards = glm::dvec3(before.world_from_camera[2]);
  size_t counts[3] = {};
  for (size_t i = 0; i < occlusion.size(); ++i) {
    ASSERT_EQ(position[i].w, 1) << "the wall is everywhere";
    const glm::dvec3 point(position[i]);
    const double x_m = (camera_from_world * glm::dvec4(point, 1)).x;
    constexpr double kPixel = 2.4 / kLabelExtent.height;
    if (std::abs(std::abs(x_m) - 1.6) < 0.01 * kPixel) continue;  // at the border
    uint32_t want = std::abs(x_m) < 1.6 ? 0u : 2u;
    if (want == 0) {
      // The sides of the plate that the ray to the point passes: of its box, in Y and X.
      bool hits = false, misses = false;
      for (const double grow : {-2 * kPixel, 2 * kPixel}) {
        double first = 1e-6, last = 1e9;
        const glm::dvec3 half(0.4 + grow, 0.05 + grow, 0.4 + grow), middle(0, 1, 0);
        for (int axis = 0; axis < 3; ++axis) {
          if (std::abs(towards[axis]) < 1e-9) {
            if (std::abs(point[axis] - middle[axis]) > half[axis]) first = 2e9;
            continue;
          }
          const double a = (middle[axis] - half[axis] - point[axis]) / towards[axis],
                       b = (middle[axis] + half[axis] - point[axis]) / towards[axis];
          first = std::max(first, std::min(a, b));
          last = std::min(last, std::max(a, b));
        }
        (first < last ? hits : misses) = true;
      }
      if (hits && misses) continue;  // at the plate's edge
      want = hits ? 1 : 0;
    }
    ASSERT_EQ(occlusion[i], want) << i;
    ++counts[want];
  }
  EXPECT_GT(counts[0], 3000u);
  EXPECT_GT(counts[1], 100u);
  EXPECT_GT(counts[2], 200u);
}

// What lay beyond the last image's far plane was outside of it.
TEST_F(Occlusion, OcclusionBeyondFarPlane) {
  const scene::Scene scene = plate_and_wall();
  RenderBench bench(scene, kLabelExtent, plain());
  const state::PoseState poses(scene);
  const auto outputs = wire::with_sources(wire::ImageOutputs(wire::kOcclusionU32 | wire::kInstanceU32));
  Eye before = eye_at({0, 0, 4}, {0, 0, 0});
  const Eye now = eye_at({0, 0, 3.9f}, {0, 0, 0});
  before.intrinsics.far_m = 3.8f;  // behind the plate and the boxes, before the wall
  passes::CameraHistory history;
  bench.take(poses, view_through(before), outputs, &history);
  const Taken taken = bench.take(poses, view_through(now), outputs, &history);
  const auto occlusion = taken.plane<uint32_t>(wire::kOcclusionU32),
             instances = taken.plane<uint32_t>(wire::kInstanceU32);
  size_t of_wall = 0;
  for (size_t i = 0; i < occlusion.size(); ++i) {
    of_wall += instances[i] == kWall + 1 ? 1 : 0;
    if (instances[i] != kWall + 1 && instances[i] != kPlate + 1) continue;
    ASSERT_EQ(occlusion[i], instances[i] == kWall + 1 ? 2u : 0u) << i;
  }
  EXPECT_GT(of_wall, 2000u);
}

// Histories reference depths up to a limit; beyond it images are refused, and what is dropped makes room.
TEST_F(Occlusion, DepthsOfHistoriesHaveALimit) {
  const scene::Scene scene = plate_and_wall();
  const auto outputs = wire::with_sources(wire::ImageOutputs(wire::kOcclusionU32));
  constexpr VkExtent2D kLarge{2048, 2048};  // 16 MiB of depth
  RenderBench bench(scene, kLarge, plain());
  const state::PoseState poses(scene);
  const passes::View view = view_through(eye_at({0, 0, 4}, {0, 0, 0}));
  std::vector<passes::CameraHistory> histories(16);
  for (passes::CameraHistory& history : histories) {
    gpu::Recorder& recorder = bench.frames().begin();
    bench.renderer().record(bench.prepare({.outputs = outputs}), recorder, bench.frames().staging(), poses,
                            view, &history);
    bench.frames().submit();
    ASSERT_TRUE(history.depth);
  }
  passes::Shortage shortage{};
  EXPECT_FALSE(bench.renderer().prepare({.extent = kLarge, .outputs = outputs}, &shortage));
  EXPECT_EQ(shortage, passes::Shortage::motion_snapshots);
  EXPECT_TRUE(bench.renderer().prepare({.extent = kLarge, .outputs = outputs, .has_history = false}))
      << "an image that no other follows needs no room";
  // The next image of a known camera replaces its depth.
  const passes::CameraHistory* const known = histories.data();
  const passes::ReplacedMemory replaced =
      passes::replaced_by(std::span(&known, 1), {kLarge.width, kLarge.height});
  EXPECT_EQ(replaced.depths, 1u);
  gpu::Recorder& recorder = bench.frames().begin();
  const gpu::Buffer* const depth = histories[0].depth.get();
  bench.renderer().record(bench.prepare({.outputs = outputs, .replaced = replaced}), recorder,
                          bench.frames().staging(), poses, view, histories.data());
  bench.frames().submit();
  EXPECT_EQ(histories[0].depth.get(), depth);
  const passes::CameraHistory copy = histories[1];
  const passes::CameraHistory* const shared = &histories[1];
  EXPECT_EQ(passes::replaced_by(std::span(&shared, 1), {kLarge.width, kLarge.height}).depths, 0u)
      << "the copy needs it";
  histories.pop_back();
  EXPECT_TRUE(bench.renderer().prepare({.extent = kLarge, .outputs = outputs}, &shortage));
}

// A pose snapshot that one camera references is replaced by its next image; one of two cameras is not.
TEST_F(Occlusion, ReplacedPosesAreThoseOfTheseCamerasAlone) {
  const scene::Scene scene = plate_and_wall();
  RenderBench bench(scene, kLabelExtent, plain());
  const state::PoseState poses(scene);
  const std::vector<passes::View> views(2, view_through(eye_at({0, 0, 4}, {0, 0, 0})));
  std::vector<passes::CameraHistory> histories(2);
  bench.take(poses, views, wire::with_sources(wire::ImageOutputs(wire::kMotion)), histories);
  EXPECT_TRUE(bench.renderer().prepare({.extent = kLabelExtent}));  // the next frame
  const std::vector<const passes::CameraHistory*> both{&histories[0], &histories[1]};
  EXPECT_FALSE(passes::replaced_by(std::span(both).first(1), {}).poses);
  EXPECT_TRUE(passes::replaced_by(both, {}).poses);
}

}  // namespace
}  // namespace fire3dv::test
