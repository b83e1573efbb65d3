// Render test of many cameras in one submission: each image is bit-identical to one drawn alone.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/passes/outputs/planes_and_boxes.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kCamerasExtent{48, 40};
constexpr uint32_t kViews = 7;

// Opaque and alpha-masked objects, small and large triangles, and a light.
scene::Scene cameras_stage() {
  SceneBuilder builder;
  scene::Material sieve = matte({0.9f, 0.8f, 0.2f});
  sieve.alpha_mode = scene::AlphaMode::mask;
  sieve.double_sided = true;
  sieve.base_color_texture.texture = builder.texture(16, 16, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, std::fmod(u * 4, 1.0f) < 0.5f || std::fmod(v * 4, 1.0f) < 0.5f ? 1 : 0);
  });
  builder.mesh_node("floor", builder.quad(builder.material(matte({0.5f, 0.6f, 0.7f})), 20), glm::mat4(1));
  builder.mesh_node("ball", builder.sphere(builder.material(matte({0.8f, 0.2f, 0.2f})), 0.6f, 64),
                    at({0, 0.7f, 0}));
  builder.mesh_node("box", builder.box(builder.material(matte({0.2f, 0.7f, 0.3f})), {0.3f, 0.8f, 0.3f}),
                    at({1.2f, 0.8f, -0.5f}));
  builder.mesh_node("sieve", builder.quad(builder.material(sieve), 0.8f),
                    at({-1, 1, 0.5f}) * glm::rotate(glm::mat4(1), 1.2f, glm::vec3(1, 0, 0.3f)));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({-1, -2, -0.5f}));
  builder.camera_node("camera", {0, 2, 5}, {0, 0.5f, 0});
  return builder.build();
}

// Cameras around the scene, near and far, each with its own lens and exposure.
std::vector<passes::View> views() {
  std::vector<passes::View> views;
  for (uint32_t i = 0; i < kViews; ++i) {
    const float angle = 0.9f * static_cast<float>(i), distance_m = 2.5f + static_cast<float>(i);
    passes::Intrinsics k;
    k.fx_px = k.fy_px = 40 + 5 * static_cast<float>(i);
    k.cx_px = 20 + static_cast<float>(i);
    k.cy_px = 20;
    k.image_px = {kCamerasExtent.width, kCamerasExtent.height};
    views.push_back(passes::make_view(
        k, passes::look_at_pose({distance_m * std::sin(angle), 1.5f, distance_m * std::cos(angle)},
                                {0, 0.6f, 0})));
    views.back().exposure = 0.5f + 0.2f * static_cast<float>(i);
  }
  return views;
}

template <typename T>
std::vector<T> part(const std::vector<T>& whole, uint32_t view, size_t size) {
  const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(view * size);
  return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

settings::DrawSettings settings_of(uint32_t samples, settings::ShadowMethod shadows, bool fxaa = false) {
  settings::DrawSettings settings;
  settings.samples = samples;
  settings.shadows.method = shadows;
  settings.post.fxaa = fxaa;
  return settings;
}

struct Case {
  uint32_t samples;
  settings::ShadowMethod shadows;
  bool fxaa = false;
  uint32_t views = kViews;
};
class ManyCameras : public ValidationIsSilent, public ::testing::WithParamInterface<Case> {};
class MoreCameras : public ValidationIsSilent {};

TEST_P(ManyCameras, BatchMatchesSingleImages) {
  const scene::Scene scene = cameras_stage();
  state::PoseState poses(scene);
  state::RestPose moved = state::rest_pose(scene);
  moved.parent_from_node[1] = moved.world_from_node[1] = at({0.3f, 0.9f, 0.2f});
  std::vector<passes::View> views = test::views();
  views.resize(GetParam().views);
  wire::ImageOutputs outputs = wire::ImageOutputs::all_planes();
  outputs.remove(wire::kColorLinearF16);
  const settings::DrawSettings settings =
      settings_of(GetParam().samples, GetParam().shadows, GetParam().fxaa);
  RenderBench one(scene, kCamerasExtent, settings);
  RenderBench many(scene, kCamerasExtent, settings);
  std::vector<passes::CameraHistory> histories(views.size()), histories_alone(views.size());
  for (int image = 0; image < 2; ++image) {
    const Taken all = many.take(poses, views, outputs, histories);
    ASSERT_EQ(all.image.height, kCamerasExtent.height * views.size());
    constexpr size_t kPixels = size_t{kCamerasExtent.width} * kCamerasExtent.height;
    for (uint32_t v = 0; v < views.size(); ++v) {
      SCOPED_TRACE(v);
      const Taken alone = one.take(poses, views[v], outputs, &histories_alone[v]);
      EXPECT_EQ(part(all.image.rgba8, v, 4 * kPixels), alone.image.rgba8);
      ASSERT_EQ(alone.places.size(), 10u);
      for (const passes::PlaneRange& place : alone.places)
        EXPECT_EQ(part(all.plane<uint8_t>(place.output), v, place.size_bytes),
                  alone.plane<uint8_t>(place.output))
            << wire::info_of(place.output).api_name;
    }
    poses.set_rest(moved);
  }
}
INSTANTIATE_TEST_SUITE_P(
    Ways, ManyCameras,
    ::testing::Values(Case{1, settings::ShadowMethod::off}, Case{4, settings::ShadowMethod::off},
                      Case{4, settings::ShadowMethod::map}, Case{1, settings::ShadowMethod::ray},
                      Case{1, settings::ShadowMethod::off, true}, Case{4, settings::ShadowMethod::map, true},
                      // So few have a dispatch each.
                      Case{1, settings::ShadowMethod::off, false, 2},
                      Case{4, settings::ShadowMethod::map, true, 2}));

// Edges that cross the borders between images in the stack, and taps that follow them: stripes of high
// contrast, of odd sizes.
TEST_F(MoreCameras, FxaaStaysInItsImage) {
  SceneBuilder builder;
  scene::Material stripes = matte({1, 1, 1});
  stripes.unlit = true;
  stripes.base_color_texture.texture = builder.texture(64, 64, false, [](float u, float v) {
    return glm::vec4(glm::vec3(std::fmod(u * 9 + v * 3, 1.0f) < 0.5f ? 1 : 0), 1);
  });
  builder.mesh_node("wall", builder.quad(builder.material(stripes), 20), glm::mat4(1));
  builder.camera_node("camera", {0, 5, 0.1f}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  const state::PoseState poses(scene);
  constexpr VkExtent2D kOdd{37, 29};
  std::vector<passes::View> views;
  for (uint32_t i = 0; i < kViews; ++i) {
    passes::Intrinsics k;
    k.fx_px = k.fy_px = 30;
    k.cx_px = 18;
    k.cy_px = 14;
    k.image_px = {kOdd.width, kOdd.height};
    const float x_m = 0.7f * static_cast<float>(i);
    views.push_back(passes::make_view(k, passes::look_at_pose({x_m, 4, 1.5f}, {x_m, 0, 0})));
  }
  RenderBench smooth(scene, kOdd, settings_of(1, settings::ShadowMethod::off, true));
  RenderBench sharp(scene, kOdd, settings_of(1, settings::ShadowMethod::off));
  std::vector<passes::CameraHistory> histories(kViews);
  const Taken all = smooth.take(poses, views, {}, histories);
  const size_t bytes = size_t{4} * kOdd.width * kOdd.height;
  for (uint32_t v = 0; v < kViews; ++v) {
    SCOPED_TRACE(v);
    const sinks::FrameImage alone = smooth.draw(poses, views[v]);
    EXPECT_EQ(part(all.image.rgba8, v, bytes), alone.rgba8);
    EXPECT_NE(alone.rgba8, sharp.draw(poses, views[v]).rgba8) << "nothing was smoothed";
  }
}

// Two sizes and two sets of outputs in one submission; the first needs no shadows.
TEST_F(MoreCameras, FrameHasSeveralImageSizes) {
  const scene::Scene scene = cameras_stage();
  const state::PoseState poses(scene);
  const std::vector<passes::View> views = test::views();
  wire::ImageOutputs labels;
  labels.remove(wire::kColorSrgb8);
  labels.add(wire::kInstanceU32);
  const settings::DrawSettings settings = settings_of(4, settings::ShadowMethod::ray);
  RenderBench alone(scene, kCamerasExtent, settings), bench(scene, kCamerasExtent, settings);
  const Taken labels_alone = alone.take(poses, views[1], labels);
  const sinks::FrameImage first_alone = alone.draw(poses, views[2]);
  const sinks::FrameImage second_alone = alone.draw(poses, views[4]);

  passes::SceneRenderer& renderer = bench.renderer();
  gpu::ReadbackRing<int> readback(device());
  gpu::Recorder& recorder = bench.frames().begin();
  gpu::StagingRing& staging = bench.frames().staging();
  renderer.record(bench.prepare({.outputs = labels}), recorder, staging, poses, views[1]);
  readback.record(recorder, nullptr, kCamerasExtent,
                  {&renderer.planes(), passes::bytes_of(renderer.plane_ranges())}, 0);
  const std::vector<passes::View> two{views[2], views[4]};
  const passes::PreparedFrame prepared = bench.prepare({.views = 2, .scene = passes::SceneUpdate::reuse});
  renderer.record(prepared, recorder, staging, poses, two);
  readback.record(recorder, renderer.image(), 1);
  readback.submitted(bench.frames().submit());
  std::vector<std::vector<uint8_t>> taken(2);
  readback.drain([&](int index, VkExtent2D, std::span<const uint8_t> bytes) {
    taken[static_cast<size_t>(index)].assign(bytes.begin(), bytes.end());
  });
  EXPECT_EQ(taken[0], labels_alone.planes);
  const size_t half = taken[1].size() / 2;
  EXPECT_EQ(part(taken[1], 0, half), first_alone.rgba8);
  EXPECT_EQ(part(taken[1], 1, half), second_alone.rgba8);
}

// More views than one image holds: the error has the number that fits.
TEST_F(MoreCameras, TooManyViewsAreRefused) {
  const scene::Scene scene = cameras_stage();
  RenderBench bench(scene, kCamerasExtent);
  const uint32_t fitting = device().limits().maxImageDimension2D / 4096;
  passes::Shortage shortage{};
  const Result<passes::PreparedFrame> prepared =
      bench.renderer().prepare({.extent = {16, 4096}, .views = fitting + 1}, &shortage);
  ASSERT_FALSE(prepared);
  EXPECT_EQ(shortage, passes::Shortage::too_many_views);
  EXPECT_NE(prepared.error().message.find("at most " + std::to_string(fitting) + " at once"),
            std::string::npos)
      << prepared.error().message;
}

TEST_F(MoreCameras, ImpossibleImagesAreRefused) {
  SceneBuilder builder;
  scene::Material glass = matte({1, 1, 1});
  glass.alpha_mode = scene::AlphaMode::blend;
  glass.base_color.a = 0.5f;
  builder.mesh_node("pane", builder.quad(builder.material(glass), 1), glm::mat4(1));
  builder.camera_node("camera", {0, 2, 5}, {0, 0, 0});
  const scene::Scene scene = builder.build();
  RenderBench bench(scene, kCamerasExtent);
  EXPECT_TRUE(bench.renderer().can_take({}, 1));
  EXPECT_FALSE(bench.renderer().can_take({}, 2));
  // The next recorded frame may show hidden nodes again.
  scene::SceneEdits edits;
  scene::NodeEdits hidden;
  hidden[0].hidden = true;
  edits.set(scene, std::move(hidden), scene::kNone);
  bench.renderer().set_edits(edits);
  bench.draw(state::PoseState(scene), views()[0]);
  EXPECT_FALSE(bench.renderer().can_take({}, 2));
}

}  // namespace
}  // namespace fire3dv::test
