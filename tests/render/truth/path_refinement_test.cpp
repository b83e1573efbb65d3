// Render tests of path-traced images that refine over several frames: their bytes, and when they start again.
#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <vector>

#include "renderer/passes/path/path_pass.h"
#include "renderer/state/motion/animation.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"
#include "tests/render/support/truth_scenes.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kExtent{24, 16};

passes::View from_above() {
  scene::Camera camera;
  return passes::make_view(camera, passes::look_at_pose({0, 4, 0.1f}, {0, 0, 0}),
                           float(kExtent.width) / float(kExtent.height));
}

// The scene at rest, but for one node below none.
state::RestPose moved(const scene::Scene& scene, uint32_t node, const glm::mat4& world_from_node) {
  state::RestPose pose = state::rest_pose(scene);
  pose.parent_from_node[node] = pose.world_from_node[node] = world_from_node;
  return pose;
}

// More bands than one submission traces, so that a first sample needs several frames.
settings::DrawSettings banded_settings(uint32_t samples) {
  settings::DrawSettings settings = path_settings(samples, 1);
  settings.path->pixels_per_dispatch = 3;
  settings.path->segments_per_dispatch = 3;
  return settings;
}

class PathRefinement : public ValidationIsSilent {
 protected:
  settings::PathProgress progress() { return bench_.renderer().path_tracer()->progress(); }
  // Refines until the image is whole; fails if it does not become so.
  sinks::FrameImage refine_to_end() {
    for (int frame = 0; frame < 1000; ++frame) {
      sinks::FrameImage image = bench_.refine(poses_, view_);
      if (progress().is_whole()) return image;
    }
    ADD_FAILURE() << "the image does not become whole";
    return {};
  }
  // Traces the first sample of a selected image, unless it has one.
  void begin_image(uint64_t number) {
    bench_.renderer().path_tracer()->select(number);
    for (int frame = 0; frame < 1000 && progress().samples == 0; ++frame) (void)bench_.refine(poses_, view_);
    ASSERT_GT(progress().samples, 0u);
  }
  // Image of another renderer, in one call.
  std::vector<uint8_t> whole_image(const settings::DrawSettings& settings) {
    RenderBench bench(scene_, kExtent, settings);
    return bench.draw(poses_, view_).rgba8;
  }

  const scene::Scene scene_ = lit_ball();
  settings::DrawSettings settings_ = banded_settings(3);
  RenderBench bench_{scene_, kExtent, settings_};
  state::PoseState poses_{scene_};
  passes::View view_ = first_camera_view(scene_, poses_, kExtent);
};

TEST_F(PathRefinement, HasBytesOfWholeImage) {
  (void)bench_.refine(poses_, view_);
  EXPECT_EQ(progress().samples, 0u) << "one submission traced a whole sample";
  const std::vector<uint8_t> refined = refine_to_end().rgba8;
  EXPECT_EQ(refined, whole_image(settings_));
  EXPECT_EQ(bench_.refine(poses_, view_).rgba8, refined) << "a whole image changes";
  // More samples go on with it.
  settings_.path->samples_per_pixel = 4;
  bench_.renderer().apply(settings_);
  EXPECT_EQ(progress().samples, 3u);
  EXPECT_EQ(refine_to_end().rgba8, whole_image(settings_));
  // Fewer have to start again.
  settings_.path->samples_per_pixel = 2;
  bench_.renderer().apply(settings_);
  EXPECT_EQ(refine_to_end().rgba8, whole_image(settings_));
}

TEST_F(PathRefinement, LastImageStaysUntilFirstSample) {
  const std::vector<uint8_t> last = refine_to_end().rgba8;
  const passes::View from_camera = view_;
  view_ = from_above();
  EXPECT_EQ(bench_.refine(poses_, view_).rgba8, last);
  EXPECT_EQ(progress().samples, 0u);
  // The first sample becomes whole although the view changes again, so that a moving view is seen to move.
  view_ = from_camera;
  std::vector<uint8_t> shown = last;
  for (int frame = 0; frame < 1000 && progress().samples == 0; ++frame)
    shown = bench_.refine(poses_, view_).rgba8;
  EXPECT_NE(shown, last);
  EXPECT_EQ(refine_to_end().rgba8, last);
}

TEST_F(PathRefinement, PoseChangeRestarts) {
  const std::vector<uint8_t> at_rest = refine_to_end().rgba8;
  const uint64_t revision = poses_.revision();
  poses_.set_rest(state::rest_pose(scene_));
  ASSERT_NE(poses_.revision(), revision);
  EXPECT_EQ(bench_.refine(poses_, view_).rgba8, at_rest);
  EXPECT_TRUE(progress().is_whole()) << "the same poses start the image again";

  poses_.set_rest(moved(scene_, 0, at({0.4f, 0.7f, 0})));
  (void)bench_.refine(poses_, view_);
  EXPECT_FALSE(progress().is_whole());
  const std::vector<uint8_t> after = refine_to_end().rgba8;
  EXPECT_NE(after, at_rest);
  EXPECT_EQ(after, whole_image(settings_));
}

TEST_F(PathRefinement, LightChangeRestartsExposureDoesNot) {
  const std::vector<uint8_t> dark = refine_to_end().rgba8;
  settings_.post.exposure = 0.5f;
  bench_.renderer().apply(settings_);
  EXPECT_NE(bench_.refine(poses_, view_).rgba8, dark);
  EXPECT_TRUE(progress().is_whole()) << "exposure starts the image again";
  EXPECT_EQ(bench_.refine(poses_, view_).rgba8, whole_image(settings_));

  settings_.environment_intensity = 1;
  bench_.renderer().apply(settings_);
  (void)bench_.refine(poses_, view_);
  EXPECT_FALSE(progress().is_whole());
  EXPECT_EQ(refine_to_end().rgba8, whole_image(settings_));
  settings_.path->bounces = 0;
  bench_.renderer().apply(settings_);
  EXPECT_EQ(refine_to_end().rgba8, whole_image(settings_));
}

// Two views in turn, each for a sample, and a third one that nobody goes on with.
TEST_F(PathRefinement, SelectedImagesKeepTheirSamples) {
  const passes::View views[] = {view_, from_above()};
  uint32_t samples[] = {0, 0};
  std::vector<uint8_t> images[2];
  for (int turn = 0; turn < 6; ++turn) {
    const size_t number = static_cast<size_t>(turn) % 2;
    bench_.renderer().path_tracer()->select(number + 7);
    for (int frame = 0; frame < 1000 && progress().samples == samples[number]; ++frame)
      images[number] = bench_.refine(poses_, views[number]).rgba8;
    ASSERT_GT(progress().samples, samples[number]) << "image " << number << " has started again";
    samples[number] = progress().samples;
    if (samples[number] == 3) continue;
    begin_image(9);
  }
  for (const size_t number : {size_t{0}, size_t{1}}) {
    view_ = views[number];
    EXPECT_EQ(samples[number], 3u);
    EXPECT_EQ(images[number], whole_image(settings_));
  }
  // Other poses end all of them.
  bench_.renderer().path_tracer()->select(7);
  EXPECT_TRUE(progress().is_whole());
  poses_.set_rest(moved(scene_, 0, at({0.4f, 0.7f, 0})));
  (void)bench_.refine(poses_, view_);
  bench_.renderer().path_tracer()->select(8);
  EXPECT_EQ(progress().samples, 0u);
}

// More images than have room: the one that was selected first has no samples any more.
TEST_F(PathRefinement, FewImagesKeepTheirSamples) {
  for (uint64_t image = 1; image <= passes::PathPass::kMaxOtherImages + 2; ++image) begin_image(image);
  bench_.renderer().path_tracer()->select(1);
  EXPECT_EQ(progress().samples, 0u);
  bench_.renderer().path_tracer()->select(3);
  EXPECT_GT(progress().samples, 0u);
  bench_.renderer().path_tracer()->forget(4);
  bench_.renderer().path_tracer()->select(4);
  EXPECT_EQ(progress().samples, 0u);
}

// An image of other poses in between, as of a client's request: no band of the image mixes both.
TEST_F(PathRefinement, ImageOfOtherPosesRestarts) {
  (void)refine_to_end();
  view_ = from_above();
  (void)bench_.refine(poses_, view_);
  ASSERT_EQ(progress().samples, 0u);
  constexpr uint32_t kLamp = 2;
  poses_.set_rest(moved(scene_, kLamp, shining_towards({0.8f, -1, 0.3f})));
  passes::ImageOutputs depth(wire::kDepthF32);
  (void)bench_.take(poses_, view_, depth);
  poses_.set_rest(state::rest_pose(scene_));
  EXPECT_EQ(refine_to_end().rgba8, whole_image(settings_));
}

// A run that is stopped at its second checkpoint, and another one that starts with it.
TEST_F(PathRefinement, CheckpointResumesToSameBytes) {
  settings_.path->samples_per_pixel = 8;
  std::vector<std::byte> sums;
  passes::PathSamples kept;
  int saved = 0;
  passes::PathHooks hooks;
  hooks.save = [&](const passes::PathSamples& now) {
    ++saved;
    sums.assign(now.sums.begin(), now.sums.end());
    kept = {now.samples, sums};
  };
  hooks.should_stop = [&] { return saved > 0; };  // at the earliest, amid a sample
  const auto trace = [&](RenderBench& bench) {
    return bench.renderer().trace_paths(bench.prepare(), poses_, view_, hooks);
  };
  RenderBench stopped(scene_, kExtent, settings_);
  EXPECT_FALSE(trace(stopped));
  EXPECT_GT(saved, 1) << "no checkpoint at the end";
  EXPECT_GT(kept.samples, 0u);
  ASSERT_LT(kept.samples, 8u);
  EXPECT_EQ(stopped.renderer().path_tracer()->progress().samples, kept.samples);

  hooks = {.resume = kept};
  RenderBench resumed(scene_, kExtent, settings_);
  const passes::PreparedFrame prepared = resumed.prepare();
  ASSERT_TRUE(resumed.renderer().trace_paths(prepared, poses_, view_, hooks));
  gpu::Recorder& recorder = resumed.frames().begin();
  resumed.renderer().record(prepared, recorder, resumed.frames().staging(), poses_, view_);
  gpu::ReadbackRing<int> readback(device());
  readback.record(recorder, resumed.renderer().image(), 0);
  readback.submitted(resumed.frames().submit());
  std::vector<uint8_t> pixels;
  readback.drain(
      [&](int, VkExtent2D, std::span<const uint8_t> bytes) { pixels.assign(bytes.begin(), bytes.end()); });
  EXPECT_EQ(pixels, whole_image(settings_));
}

}  // namespace
}  // namespace fire3dv::test
