// Render test of flow to a later image, against closed forms: deforming meshes, a moving plate and what hides
// it.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/passes/outputs/flow_pass.h"
#include "tests/render/labels/moving_scenes.h"
#include "tests/render/support/bent_bar.h"

namespace fire3dv::test {
namespace {

class Flow : public ValidationIsSilent {};

struct FlowTo {
  std::vector<glm::vec2> motion_px;
  std::vector<uint32_t> occlusion;
};

const wire::ImageOutputs kFlowSources =
    wire::with_sources(wire::ImageOutputs(wire::kMotion | wire::kOcclusionU32 | wire::kInstanceU32));

// Draws an image that later ones are compared with.
passes::CameraHistory draw_earlier(RenderBench& bench, const state::PoseState& poses,
                                   const passes::View& view) {
  passes::CameraHistory history;
  gpu::Recorder& recorder = bench.frames().begin();
  bench.renderer().record(bench.prepare({.outputs = kFlowSources, .keeps_surfaces = true}), recorder,
                          bench.frames().staging(), poses, view, &history);
  bench.frames().submit();
  EXPECT_TRUE(history.surfaces);
  return history;
}

// Flow from the earlier image to this one.
FlowTo draw_later(RenderBench& bench, const state::PoseState& poses, const passes::View& view,
                  const passes::CameraHistory& earlier) {
  passes::CameraHistory history = earlier;
  gpu::ReadbackRing<int> readback(device());
  gpu::Recorder& recorder = bench.frames().begin();
  bench.renderer().record(
      bench.prepare({.outputs = kFlowSources, .flow_from = std::make_shared<passes::CameraHistory>(earlier)}),
      recorder, bench.frames().staging(), poses, view, &history);
  readback.record(recorder, nullptr, kLabelExtent,
                  {&bench.renderer().flow(), passes::flow_bytes(kLabelExtent)}, 0);
  readback.submitted(bench.frames().submit());
  constexpr size_t kPixels = size_t{kLabelExtent.width} * kLabelExtent.height;
  FlowTo flow{std::vector<glm::vec2>(kPixels), std::vector<uint32_t>(kPixels)};
  readback.drain([&](int, VkExtent2D, std::span<const uint8_t> bytes) {
    std::memcpy(flow.motion_px.data(), bytes.data(), 8 * kPixels);
    std::memcpy(flow.occlusion.data(), bytes.data() + 8 * kPixels, 4 * kPixels);
  });
  return flow;
}

// True if all samples of the pixel show the face.
bool fills_pixel(const Eye& eye, const std::vector<Face>& faces, glm::dvec2 pixel, size_t face) {
  for (const glm::dvec2 beside :
       {glm::dvec2(0.5, 0.5), glm::dvec2(-0.5, 0.5), glm::dvec2(0.5, -0.5), glm::dvec2(-0.5, -0.5)}) {
    if (eye.cast(faces, pixel + beside).face != face) return false;
  }
  return true;
}

// Compares the flow of each pixel with faces of both moments. Returns the number of pixels with flow.
size_t expect_flow(const FlowTo& flow, const Eye& before, const Eye& now,
                   const std::vector<Face>& faces_before, const std::vector<Face>& faces_now,
                   double highest_m = 1e9, uint32_t samples = 1) {
  size_t moved = 0;
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = before.cast_surely(faces_before, {x, y});
      if (!hit || hit->instance == 0 || hit->point_world.y > highest_m) continue;
      if (samples > 1 && !fills_pixel(before, faces_before, {x, y}, hit->face)) continue;
      const glm::dvec3 point = carried(faces_before[hit->face], faces_now[hit->face], hit->point_world);
      const glm::dvec2 want = now.project(point) - glm::dvec2(x, y);
      EXPECT_LT(glm::distance(want, glm::dvec2(flow.motion_px[size_t{y} * kLabelExtent.width + x])), 0.01)
          << "at " << x << ", " << y;
      if (::testing::Test::HasFailure()) return 0;
      moved += glm::length(want) > 0.5 ? 1 : 0;
    }
  }
  return moved;
}

TEST_F(Flow, OfStreamedVerticesInBothSampleCounts) {
  const scene::Scene scene = streamed_tubes();
  const Eye before = eye_at({0.2f, 0.5f, 4.5f}, {0, 0, 0}), now = eye_at({0.3f, 0.6f, 4.4f}, {0.05f, 0, 0});
  for (const uint32_t samples : {1u, 4u}) {
    RenderBench bench(scene, kLabelExtent, plain(samples));
    scene::SceneEdits edits;
    bench.renderer().set_edits(edits);
    const state::PoseState poses(scene);
    stream_tubes(edits, scene, 0.3, 1.1);
    const passes::CameraHistory earlier = draw_earlier(bench, poses, view_through(before));
    stream_tubes(edits, scene, 0.9, 0.8);
    const FlowTo flow = draw_later(bench, poses, view_through(now), earlier);
    EXPECT_GT(expect_flow(flow, before, now, resting_faces(tube_scene(0.3, 1.1)),
                          resting_faces(tube_scene(0.9, 0.8)), 1e9, samples),
              samples == 1 ? 1000u : 200u);
    // Nothing has moved: not by a digit.
    const passes::CameraHistory same = draw_earlier(bench, poses, view_through(now));
    for (const glm::vec2& motion : draw_later(bench, poses, view_through(now), same).motion_px)
      ASSERT_EQ(motion, glm::vec2(0));
    stream_tubes(edits, scene, 0.9, 0.8, true);
    const FlowTo hidden = draw_later(bench, poses, view_through(now), same);
    size_t of_node = 0, at_edges = 0;
    for (size_t i = 0; i < hidden.occlusion.size(); ++i) {
      const bool is_of_node = std::isnan(hidden.motion_px[i].x);
      of_node += is_of_node ? 1 : 0;
      ASSERT_TRUE(!is_of_node || hidden.occlusion[i] == 1) << "a node that is hidden later, at " << i;
      at_edges += !is_of_node && hidden.occlusion[i] == 1 ? 1 : 0;
    }
    EXPECT_GT(of_node, 300u);
    EXPECT_LT(at_edges, 10u) << "of others, where the pixel's centre is beside the triangle";
  }
}

TEST_F(Flow, OfSkinnedArm) {
  BarPose first, second;
  first.bulge = 0.2f;
  first.root_from_tip = at({0, 1, 0}) * glm::rotate(glm::mat4(1), 0.2f, glm::vec3(0, 0, 1));
  second.bulge = 0.7f;
  second.world_from_root = at({0.1f, 0.05f, 0});
  second.root_from_tip = at({0, 1, 0}) * glm::rotate(glm::mat4(1), 0.5f, glm::vec3(0, 0, 1));
  const scene::Scene scene = skinned_bar(first);
  const Eye before = eye_at({1, 2.5f, 4.5f}, {0, 0.9f, 0}), now = eye_at({1.1f, 2.5f, 4.4f}, {0, 0.9f, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  const passes::CameraHistory earlier = draw_earlier(bench, poses, view_through(before));
  poses.set_rest(moved(scene, second));
  const FlowTo flow = draw_later(bench, poses, view_through(now), earlier);
  // Above the tip's joint masked holes show what lies behind them, which the ray caster does not know.
  EXPECT_GT(expect_flow(flow, before, now, resting_faces(computed_bar(first)),
                        resting_faces(computed_bar(second)), 0.9),
            100u);
}

// The plate moves over the wall: what it hides later is hidden, what leaves the image is outside.
TEST_F(Flow, OcclusionByMovingPlate) {
  const scene::Scene scene = plate_and_wall();
  const Eye before = eye_at({0, 0, 4}, {0, 0, 0}), now = eye_at({0.3f, 0.1f, 4}, {0.2f, 0, 0});
  RenderBench bench(scene, kLabelExtent, plain());
  state::PoseState poses(scene);
  const passes::CameraHistory earlier = draw_earlier(bench, poses, view_through(before));
  const std::vector<Face> faces_before = resting_faces(scene);
  std::vector<glm::mat4> moved_nodes;
  for (const scene::Node& node : scene.nodes) moved_nodes.push_back(node.world_from_node);
  moved_nodes[kPlate] = at({0.6f, 0.1f, 1});
  const std::vector<Face> faces_now = faces_of(scene, moved_nodes);
  state::RestPose rest = state::rest_pose(scene);
  rest.parent_from_node[kPlate] = rest.world_from_node[kPlate] = moved_nodes[kPlate];
  poses.set_rest(rest);
  const FlowTo flow = draw_later(bench, poses, view_through(now), earlier);
  size_t counts[3] = {};
  for (uint32_t y = 0; y < kLabelExtent.height; ++y) {
    for (uint32_t x = 0; x < kLabelExtent.width; ++x) {
      const auto hit = before.cast_surely(faces_before, {x, y});
      if (!hit) continue;
      uint32_t want = 0;
      if (hit->instance != 0) {
        const glm::dvec3 point = carried(faces_before[hit->face], faces_now[hit->face], hit->point_world);
        const glm::dvec2 place = now.project(point), size(kLabelExtent.width, kLabelExtent.height);
        const glm::dvec2 from_edge = glm::min(place + 0.5, size - 0.5 - place);
        const double inside_px = std::min(from_edge.x, from_edge.y);
        if (std::abs(inside_px) < 0.01) continue;
        const Hit later = now.cast(faces_now, place);
        bool is_certain = true;
        for (const glm::dvec2 aside :
             {glm::dvec2(1, 1), glm::dvec2(-1, 1), glm::dvec2(1, -1), glm::dvec2(-1, -1)})
          is_certain &= now.cast(faces_now, place + aside).instance == later.instance;
        if (inside_px > 0 && !is_certain) continue;
        want = inside_px < 0 ? 2 : later.instance != hit->instance ? 1 : 0;
      }
      ASSERT_EQ(flow.occlusion[size_t{y} * kLabelExtent.width + x], want) << "at " << x << ", " << y;
      ++counts[want];
    }
  }
  EXPECT_GT(counts[0], 3000u);
  EXPECT_GT(counts[1], 150u);
  EXPECT_GT(counts[2], 50u);
}

}  // namespace
}  // namespace fire3dv::test
