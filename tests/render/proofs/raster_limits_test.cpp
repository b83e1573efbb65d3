// Render test of boundary sizes: empty scene, one pixel, many lights, more clusters than a row of workgroups.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/passes/resources/gpu_scene.h"
#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using glm::vec3;
using settings::ShadowMethod;

settings::DrawSettings forward(settings::DrawSettings settings) {
  settings.raster = settings::RasterPath::forward;
  return settings;
}

class RasterLimits : public ValidationIsSilent {};

scene::Scene stage(int lights, scene::LightType type = scene::LightType::point) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  builder.mesh_node("ground", builder.quad(white, 4), glm::mat4(1));
  builder.mesh_node("box", builder.box(white, vec3(0.3f)), at({0, 0.3f, 0}));
  builder.mesh_node("post", builder.box(white, {0.02f, 0.5f, 0.02f}), at({0.7f, 0.5f, 0.3f}));
  for (int i = 0; i < lights; ++i) {
    const float angle = 2.3999632f * static_cast<float>(i);
    scene::Light lamp;
    lamp.type = type;
    lamp.intensity = 6.0f / static_cast<float>(lights);
    builder.light_node(
        lamp, shining_towards({0, -1, 0.01f}, {1.5f * std::cos(angle), 1.2f, 1.5f * std::sin(angle)}));
  }
  builder.camera_node("camera", {1.5f, 2, 2.5f}, {0, 0.2f, 0});
  return builder.build();
}

TEST_F(RasterLimits, FortyPointLights) {
  const scene::Scene scene = stage(40);
  const VkExtent2D extent{64, 48};
  const sinks::FrameImage all =
      RenderBench(scene, extent, shadowed_by(ShadowMethod::ray, false, 4)).draw_at_rest();
  const sinks::FrameImage hybrid =
      RenderBench(scene, extent, with_fine_maps(shadowed_by(ShadowMethod::ray, true, 4))).draw_at_rest();
  EXPECT_TRUE(matches_image(hybrid, all, "limits_forty", Tolerance::colour()));
  EXPECT_LE(compare_brightness(hybrid, all).brighter, 0u);
  EXPECT_GT(compare_brightness(RenderBench(scene, extent, plain_settings(4)).draw_at_rest(), all).brighter,
            500u)
      << "they cast no shadows";
  RenderBench(scene, extent, shadowed_by(ShadowMethod::map)).draw_at_rest();
}

TEST_F(RasterLimits, EmptySceneDraws) {
  for (ShadowMethod method : {ShadowMethod::ray, ShadowMethod::map, ShadowMethod::off}) {
    for (uint32_t samples : {1u, 4u}) {
      settings::DrawSettings settings = shadowed_by(method, true, samples);
      settings.environment_intensity = 1;
      settings.background.color = {0, 0.25f, 1};
      const scene::Scene dark = stage(0);
      const sinks::FrameImage image = RenderBench(dark, {64, 48}, settings).draw_at_rest();
      EXPECT_TRUE(matches_image(image, RenderBench(dark, {64, 48}, forward(settings)).draw_at_rest(),
                                "limits_dark", Tolerance::colour()));
      SceneBuilder empty, only_a_light;
      empty.camera_node("camera", {0, 0, 1}, {0, 0, 0});
      only_a_light.light_node(sun({1, 1, 1}, 1), glm::mat4(1));
      only_a_light.light_node(scene::Light(), glm::mat4(1));
      only_a_light.camera_node("camera", {0, 0, 1}, {0, 0, 0});
      for (const scene::Scene& scene : {empty.build(), only_a_light.build()}) {
        const sinks::FrameImage nothing = RenderBench(scene, {64, 48}, settings).draw_at_rest();
        for (uint32_t y = 0; y < 48; ++y) {
          for (uint32_t x = 0; x < 64; ++x) ASSERT_EQ(pixel(nothing, x, y), glm::ivec3(0, 137, 255));
        }
      }
    }
  }
}

TEST_F(RasterLimits, OddSizes) {
  const scene::Scene scene = stage(2, scene::LightType::spot);
  for (VkExtent2D extent : {VkExtent2D{1, 1}, {1, 7}, {9, 1}, {33, 31}, {127, 3}, {65, 97}}) {
    SCOPED_TRACE(testing::Message() << extent.width << " x " << extent.height);
    const settings::DrawSettings settings = shadowed_by(ShadowMethod::ray, true, 4);
    const sinks::FrameImage image = RenderBench(scene, extent, settings).draw_at_rest();
    const sinks::FrameImage reference = RenderBench(scene, extent, forward(settings)).draw_at_rest();
    EXPECT_EQ(image.rgba8.size(), size_t{4} * extent.width * extent.height);
    // The image is too small for fractions of pixels: object and shadow edges may differ.
    const Brightness seen = compare_brightness(image, reference, 3 * 8);
    EXPECT_LE(seen.brighter + seen.darker, 1 + extent.width * extent.height / 100);
  }
}

// More visible cluster instances than one row of workgroups: each is drawn.
TEST_F(RasterLimits, ClustersExceedOneRow) {
  constexpr int kSide = 264;  // 69,696 boxes of one cluster each
  SceneBuilder builder;
  scene::Material glowing = matte({1, 1, 1});
  glowing.unlit = true;
  const uint32_t box = builder.box(builder.material(glowing), vec3(0.3f));
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      builder.mesh_node("", box, at({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 0}));
    }
  }
  builder.light_node(sun({1, 1, 1}, 1), shining_towards({0, 0, -1}));
  const scene::Scene scene = builder.build();
  ProofBench bench({kSide, kSide}, shadowed_by(ShadowMethod::ray, true));
  bench.show(scene);
  ASSERT_GT(bench.renderer().gpu_scene().cluster_instance_count, 65535u);
  scene::Camera camera;
  camera.orthographic = true;
  camera.half_extent_m = vec3(kSide / 2.0f);
  const vec3 center(kSide / 2.0f, kSide / 2.0f, 0);
  const sinks::FrameImage image = bench.draw(camera, passes::look_at_pose(center + vec3(0, 0, 5), center));
  uint32_t seen = 0;
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) seen += pixel(image, x, y).r == 255;
  }
  EXPECT_EQ(seen, static_cast<uint32_t>(kSide * kSide));
}

TEST_F(RasterLimits, ReloadLeavesNothing) {
  const scene::Scene first = stage(3), second = stage(1, scene::LightType::spot), dark = stage(0);
  auto objects = [] {
    device().retire_all_now();
    return device().live_objects();
  };
  const gpu::LiveObjects before_all = objects();
  const uint64_t bytes_before_all = device().allocated_bytes();
  for (ShadowMethod method : {ShadowMethod::ray, ShadowMethod::map}) {
    RenderBench bench(first, {64, 48}, shadowed_by(method));
    for (uint32_t frame = 0; frame < 2 * gpu::kFramesInFlight; ++frame) bench.draw_at_rest();
    const sinks::FrameImage image = bench.draw_at_rest();
    gpu::LiveObjects before{};
    uint64_t bytes_before = 0;
    for (uint32_t i = 0; i < 4; ++i) {
      if (i == 2) {  // targets of a few sizes are cached: by now all sizes of the loop
        before = objects();
        bytes_before = device().allocated_bytes();
      }
      bench.renderer().set_scene(i % 2 ? second : dark);
      bench.set_size({1400 + i % 2, 41 + i % 2});  // this size has larger shadow maps
      RenderBench(second, {33, 32}, shadowed_by(method)).draw_at_rest();
      bench.renderer().set_scene(first);
      bench.set_size({64, 48});
      EXPECT_TRUE(matches_image(bench.draw_at_rest(), image, "limits_reload", Tolerance::exact()));
    }
    EXPECT_EQ(objects(), before);
    EXPECT_EQ(device().allocated_bytes(), bytes_before);
  }
  EXPECT_EQ(objects(), before_all);
  EXPECT_EQ(device().allocated_bytes(), bytes_before_all);
}

}  // namespace
}  // namespace fire3dv::test
