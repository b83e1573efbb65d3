// Render test of images with a time limit: batches change no byte, and what ends early leaves no trace.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/passes/resources/draw_batches.h"
#include "tests/render/support/marker_fixture.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr int64_t kForeverNs = int64_t{1} << 60;

// Layers of blended quads, one behind the other, each over the whole view.
scene::Scene layers(uint32_t count) {
  SceneBuilder builder;
  scene::Material glass = matte({0.2f, 0.5f, 0.9f});
  glass.alpha_mode = scene::AlphaMode::blend;
  glass.base_color.a = 0.1f;
  const uint32_t mesh = builder.box(builder.material(glass), {20, 20, 1e-4f});
  for (uint32_t i = 0; i < count; ++i)
    builder.mesh_node("layer " + std::to_string(i), mesh, at({0, 0, -2 - 0.01f * static_cast<float>(i)}));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({0, 0, -1}));
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1});
  return builder.build();
}

class Limits : public MarkerTest {
 protected:
  // More of each kind than one batch has.
  void show_many() {
    Marker points;
    points.kind = MarkerKind::points;
    points.width = 4;
    for (int i = 0; i < 5000; ++i)
      points.positions.push_back({0.001f * static_cast<float>(i % 300) - 0.15f,
                                  0.001f * static_cast<float>(i % 211) - 0.1f, -1 - 1e-4f * i});
    points.colors = {0x80ff4020};
    show(points);
    Marker boxes = points;
    boxes.kind = MarkerKind::boxes;
    boxes.positions.resize(700);
    boxes.sizes = {{0.02f, 0.03f, 0.01f}};
    boxes.colors = {0xff20ff40};
    show(boxes);
    Marker strip = points;
    strip.kind = MarkerKind::line_strip;
    strip.positions.resize(3000);
    show(strip);
  }
};

INSTANTIATE_TEST_SUITE_P(Paths, Limits,
                         testing::Values(settings::RasterPath::visibility, settings::RasterPath::forward),
                         [](const auto& test) {
                           return test.param == settings::RasterPath::forward ? "forward" : "visibility";
                         });

TEST_P(Limits, BatchesOfMarkersChangeNoByte) {
  show_many();
  const sinks::FrameImage whole = draw();
  bench_.frames().limits().set(kForeverNs);
  EXPECT_EQ(draw().rgba8, whole.rgba8);
  EXPECT_FALSE(bench_.frames().limits().take_ended_early());
}

TEST_P(Limits, BatchesOfBlendedSurfacesChangeNoByte) {
  const scene::Scene scene = layers(60);
  constexpr VkExtent2D kLarge{400, 300};  // few triangles a batch
  ASSERT_LT(passes::triangles_per_batch(kLarge), 12u * 60);
  RenderBench bench(scene, kLarge, settings());
  const sinks::FrameImage whole = bench.draw_at_rest();
  bench.frames().limits().set(kForeverNs);
  EXPECT_EQ(bench.draw_at_rest().rgba8, whole.rgba8);
}

TEST_P(Limits, ImageEndsEarlyAndLaterOnesAreWhole) {
  const sinks::FrameImage before = draw();
  Marker cover;
  cover.kind = MarkerKind::triangles;
  cover.positions = {{-50, -50, -1}, {50, -50, -1}, {0, 50, -1}};
  cover.colors = {0x08ffffff};
  bench_.frames().limits().set(1'000'000);
  show(cover);
  (void)draw();  // a submission that compiles its pipeline has more time
  EXPECT_FALSE(bench_.frames().limits().take_ended_early());
  // Takes many seconds as a whole.
  const std::vector<std::array<float, 3>> corners = cover.positions;
  for (int i = 0; i < 100'000; ++i)
    cover.positions.insert(cover.positions.end(), corners.begin(), corners.end());
  show(cover);
  (void)draw();
  EXPECT_TRUE(bench_.frames().limits().take_ended_early());
  EXPECT_FALSE(bench_.frames().limits().take_ended_early()) << "it is told once";
  bench_.frames().limits().set({});
  shown_.clear();
  EXPECT_EQ(draw().rgba8, before.rgba8);
  EXPECT_FALSE(bench_.frames().limits().take_ended_early());
}

// Depth of field with the widest circles everywhere: far more than a second on a CPU.
class BlurredImage : public ValidationIsSilent {
 protected:
  static settings::DrawSettings blurred(float f_number) {
    settings::DrawSettings settings;
    settings.post.lens = {f_number, 0.5f};
    return settings;
  }
  // A small image, which compiles the pipelines.
  void SetUp() override {
    bench_.set_size({32, 24});
    (void)bench_.draw_at_rest();
    bench_.set_size(kSize);
  }
  // Submits an image without waiting for it.
  uint64_t submit() {
    const passes::PreparedFrame prepared = bench_.prepare({.lens = true});
    gpu::Recorder& recorder = bench_.frames().begin();
    bench_.renderer().record(prepared, recorder, bench_.frames().staging(), poses_,
                             first_camera_view(scene_, poses_, kSize));
    return bench_.frames().submit();
  }
  void expect_early_end(uint64_t submission) {
    device().wait(submission);
    EXPECT_TRUE(bench_.frames().limits().has_ended_early(submission));
  }

  static constexpr VkExtent2D kSize{800, 600};
  const scene::Scene scene_ = layers(1);
  const state::PoseState poses_{scene_};
  RenderBench bench_{scene_, kSize, blurred(0.1f)};
};

TEST_F(BlurredImage, EndsAtItsOwnLimitAndBlamesNoContent) {
  using Cause = gpu::SubmissionLimits::Cause;
  bench_.frames().limits().set(1'000'000, Cause::image);
  const uint64_t first = submit();
  const uint64_t behind = submit();
  expect_early_end(first);
  expect_early_end(behind);
  EXPECT_FALSE(bench_.frames().limits().take_ended_early());
}

TEST_F(BlurredImage, EndsWithoutALimitWhenNobodyWaitsForIt) {
  const uint64_t withdrawn = submit();
  bench_.frames().end_early(withdrawn);
  expect_early_end(withdrawn);
  // Once it is done, its words may belong to another image.
  bench_.frames().end_early(withdrawn);
  bench_.change_settings([](settings::DrawSettings& settings) { settings.post.lens = {}; });
  const sinks::FrameImage sharp = bench_.draw_at_rest();
  EXPECT_EQ(sharp.rgba8, RenderBench(scene_, kSize).draw_at_rest().rgba8);
}

TEST(Batches, ShrinkWithTheAreaAndKeepALeast) {
  EXPECT_EQ(passes::triangles_per_batch({64, 64}), 1024u);
  EXPECT_LT(passes::triangles_per_batch({128, 64}), passes::triangles_per_batch({64, 64}));
  EXPECT_EQ(passes::triangles_per_batch({4096, 4096}), 64u);
  EXPECT_EQ(passes::triangles_per_batch({0, 0}), 1u << 16);
}

}  // namespace
}  // namespace fire3dv::test
