// Render test of bloom and metered exposure: conservation of energy, closed forms, independence of other
// images, agreement of all paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class PostEffects : public ValidationIsSilent {};

double decode(int encoded) {
  const double value = encoded / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

scene::Material glowing(glm::vec3 radiance) {
  scene::Material material = matte({0, 0, 0});
  material.specular = 0;
  material.emissive = radiance;
  return material;
}

// Colours of the display are proportional to light.
settings::DrawSettings bloom_settings(float strength, uint32_t samples = 1) {
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.samples = samples;
  settings.post.tone_map = settings::ToneMap::none;
  settings.post.fxaa = false;
  settings.post.bloom = strength;
  return settings;
}

constexpr VkExtent2D kSize{101, 75};

// A camera one metre above a plane of which the image shows one metre of height.
SceneBuilder plane_camera() {
  SceneBuilder builder;
  builder.camera_node("camera", {0, 1, 0}, {0, 0, 0}, 2 * std::atan(0.5f));
  return builder;
}

// A square of one pixel, at a pixel counted from the image's centre.
scene::Scene bright_pixel(float radiance, float right, float down) {
  SceneBuilder builder = plane_camera();
  const float pixel_m = 1.0f / static_cast<float>(kSize.height);
  builder.mesh_node("pixel", builder.quad(builder.material(glowing(glm::vec3(radiance))), pixel_m / 2),
                    at({right * pixel_m, 0, down * pixel_m}));
  return builder.build();
}

double energy(const sinks::FrameImage& image) {
  double sum = 0;
  for (size_t i = 0; i < image.rgba8.size(); i += 4) sum += decode(image.rgba8[i]);
  return sum;
}

sinks::FrameImage drawn(const scene::Scene& scene, const settings::DrawSettings& settings,
                        VkExtent2D extent = kSize) {
  return RenderBench(scene, extent, settings).draw_at_rest();
}

int largest_difference(const sinks::FrameImage& a, const sinks::FrameImage& b) {
  EXPECT_EQ(a.rgba8.size(), b.rgba8.size());
  int largest = 0;
  for (size_t i = 0; i < std::min(a.rgba8.size(), b.rgba8.size()); ++i)
    largest = std::max(largest, std::abs(a.rgba8[i] - b.rgba8[i]));
  return largest;
}

TEST_F(PostEffects, BloomConservesEnergy) {
  constexpr float kRadiance = 24;
  const scene::Scene scene = bright_pixel(kRadiance, 0, 0);
  const sinks::FrameImage image = drawn(scene, bloom_settings(1));
  EXPECT_NEAR(energy(image), kRadiance, 0.01 * kRadiance);
  const glm::ivec3 peak = pixel(image, kSize.width / 2, kSize.height / 2);
  EXPECT_LT(peak.g, 255) << "a clipped pixel would hide energy";
  EXPECT_GT(peak.g, 200);
  EXPECT_GT(pixel(image, kSize.width / 2 + 12, kSize.height / 2).g, 10) << "the light is spread";
  // The mix is linear: half of the light stays in its pixel.
  const double kept = decode(
      pixel(drawn(bright_pixel(1.6f, 0, 0), bloom_settings(0.5f)), kSize.width / 2, kSize.height / 2).g);
  EXPECT_NEAR(kept, 0.5 * 1.6 + 0.5 * 1.6 / kRadiance * decode(peak.g), 0.01);
}

TEST_F(PostEffects, BloomAtEdgeConservesEnergy) {
  constexpr float kRadiance = 12;
  for (const float side : {-1.0f, 1.0f}) {
    const double found = energy(drawn(bright_pixel(kRadiance, side * 49, side * 36), bloom_settings(1)));
    EXPECT_NEAR(found, kRadiance, 0.15 * kRadiance) << side;
  }
}

TEST_F(PostEffects, BloomKeepsUniformImage) {
  SceneBuilder builder = plane_camera();
  builder.mesh_node("wall", builder.quad(builder.material(glowing({0.1f, 0.4f, 0.7f})), 10), glm::mat4(1));
  const scene::Scene scene = builder.build();
  EXPECT_LE(largest_difference(drawn(scene, bloom_settings(0.8f)), drawn(scene, bloom_settings(0))), 1);
  // Display-referred colours count as light of the brightness that is shown, whatever the exposure.
  SceneBuilder empty = plane_camera();
  const scene::Scene nothing = empty.build();
  settings::DrawSettings plain = bloom_settings(0), bloomed = bloom_settings(0.8f);
  for (settings::DrawSettings* settings : {&plain, &bloomed}) {
    settings->background.color = {0.2f, 0.5f, 0.05f};
    settings->post.exposure = 1e-4f;
  }
  EXPECT_LE(largest_difference(drawn(nothing, bloomed), drawn(nothing, plain)), 1);
}

// Lamps before a grey wall and the background, with one blended pane.
scene::Scene lamps(bool with_pane) {
  SceneBuilder builder = plane_camera();
  builder.mesh_node("wall", builder.quad(builder.material(glowing({0.05f, 0.06f, 0.08f})), 0.3f),
                    at({-0.3f, -0.2f, 0}));
  builder.mesh_node("lamp", builder.quad(builder.material(glowing({9, 6, 2})), 0.05f), at({0.2f, 0, 0.1f}));
  builder.mesh_node("lamp 2", builder.quad(builder.material(glowing({0.5f, 2, 20})), 0.02f),
                    at({-0.3f, 0, -0.2f}));
  if (with_pane) {
    scene::Material pane = glowing({0.3f, 0, 0});
    pane.base_color.a = 0.5f;
    pane.alpha_mode = scene::AlphaMode::blend;
    builder.mesh_node("pane", builder.quad(builder.material(pane), 0.1f), at({0.2f, 0.1f, 0.1f}));
  }
  return builder.build();
}

TEST_F(PostEffects, BloomMatchesAcrossRenderers) {
  for (const bool with_pane : {false, true}) {
    const scene::Scene scene = lamps(with_pane);
    for (const uint32_t samples : {1u, 4u}) {
      settings::DrawSettings settings = bloom_settings(0.4f, samples);
      settings.background.color = glm::vec3(0.02f);
      settings.post.tone_map = settings::ToneMap::neutral;
      const sinks::FrameImage visibility = drawn(scene, settings);
      settings.raster = settings::RasterPath::forward;
      EXPECT_LE(largest_difference(visibility, drawn(scene, settings)), 2) << samples << with_pane;
      if (samples == 1 || with_pane) continue;
      settings.raster = settings::RasterPath::automatic;
      settings.path = settings::PathSettings{.samples_per_pixel = 256, .bounces = 0};
      const sinks::FrameImage traced = drawn(scene, settings);
      // Far from edges, whose pixels differ in coverage. 30 pixels off the large lamp:
      for (const uint32_t x : {20u, 40u, 90u}) {
        for (int channel = 0; channel < 3; ++channel)
          EXPECT_NEAR(pixel(visibility, x, 60)[channel], pixel(traced, x, 60)[channel], 3) << x;
      }
    }
  }
}

TEST_F(PostEffects, BloomIsStatelessAndSkipsLinear) {
  const scene::Scene scene = lamps(true), other = bright_pixel(1000, 5, 5);
  passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kColorLinearF16 | wire::kDepthF32);
  const state::PoseState poses(scene);
  const passes::View view = first_camera_view(scene, poses, kSize);
  RenderBench plain(scene, kSize, bloom_settings(0, 4)), bloomed(scene, kSize, bloom_settings(0.5f, 4));
  const Taken without = plain.take(poses, view, outputs), with = bloomed.take(poses, view, outputs);
  EXPECT_EQ(without.plane<uint64_t>(wire::kColorLinearF16), with.plane<uint64_t>(wire::kColorLinearF16));
  EXPECT_EQ(without.plane<uint32_t>(wire::kDepthF32), with.plane<uint32_t>(wire::kDepthF32));
  EXPECT_GT(largest_difference(without.image, with.image), 20);
  // The same renderer after an image of another scene and size, switched off and on.
  RenderBench used(other, {64, 48}, bloom_settings(0.5f, 4));
  (void)used.draw_at_rest();
  EXPECT_FALSE(used.renderer().can_take(passes::ImageOutputs(), 2)) << "several views share no HDR target";
  EXPECT_TRUE(used.renderer().can_take(passes::ImageOutputs(wire::kDepthF32), 2)) << "effects need colours";
  used.renderer().set_scene(scene);
  used.set_size(kSize);
  EXPECT_EQ(used.draw(poses, view).rgba8, with.image.rgba8);
  used.change_settings([](settings::DrawSettings& s) { s.post.bloom = 0; });
  EXPECT_EQ(used.draw(poses, view).rgba8, plain.draw(poses, view).rgba8);
  used.change_settings([](settings::DrawSettings& s) { s.post.bloom = 0.5f; });
  EXPECT_EQ(used.draw(poses, view).rgba8, with.image.rgba8);
}

settings::DrawSettings metered_settings(uint32_t samples = 1) {
  settings::DrawSettings settings = bloom_settings(0, samples);
  settings.post.metered = true;
  return settings;
}

// A wall with a lamp whose area is a share of the image.
scene::Scene wall_and_lamp(float wall, float lamp, float share) {
  SceneBuilder builder = plane_camera();
  builder.mesh_node("wall", builder.quad(builder.material(glowing(glm::vec3(wall))), 10), glm::mat4(1));
  const float area_m2 = static_cast<float>(kSize.width) / static_cast<float>(kSize.height);
  if (share > 0)
    builder.mesh_node(
        "lamp", builder.quad(builder.material(glowing(glm::vec3(lamp))), std::sqrt(share * area_m2) / 2),
        at({0.3f, 0.001f, 0}));
  return builder.build();
}

constexpr double kMiddleGrey = 117.65;  // 255 times the sRGB encoding of 0.18

TEST_F(PostEffects, MeteringMapsUniformToMiddleGrey) {
  for (const float radiance : {3e-4f, 0.05f, 1.0f, 17.0f, 6000.0f}) {
    const scene::Scene scene = wall_and_lamp(radiance, 0, 0);
    for (const uint32_t samples : {1u, 4u}) {
      const sinks::FrameImage image = drawn(scene, metered_settings(samples));
      EXPECT_NEAR(pixel(image, 50, 37).g, kMiddleGrey, 1) << radiance;
      EXPECT_EQ(pixel(image, 3, 70), pixel(image, 50, 37));
    }
    settings::DrawSettings traced = metered_settings();
    traced.path = settings::PathSettings{.samples_per_pixel = 4, .bounces = 0};
    EXPECT_NEAR(pixel(drawn(scene, traced, {17, 9}), 8, 4).g, kMiddleGrey, 1) << radiance;
  }
}

TEST_F(PostEffects, MeteringTrimsHistogramEnds) {
  // Lamps of few pixels and small black holes do not count, however bright they are.
  for (const float lamp : {0.0f, 1e-6f, 5000.0f})
    EXPECT_NEAR(pixel(drawn(wall_and_lamp(0.3f, lamp, 0.04f), metered_settings()), 5, 5).g, kMiddleGrey, 1);
  // A larger lamp does. Of its share s and the trimmed twentieths, (s - 0.05) / 0.9 remain.
  constexpr float kShare = 0.25f, kWall = 0.3f, kLamp = 2.4f;
  const double part = (kShare - 0.05) / 0.9;
  const double mean = std::exp(part * std::log(kLamp) + (1 - part) * std::log(kWall));
  const sinks::FrameImage image = drawn(wall_and_lamp(kWall, kLamp, kShare), metered_settings());
  EXPECT_NEAR(decode(pixel(image, 5, 5).g), 0.18 * kWall / mean, 0.003);
}

TEST_F(PostEffects, MeteringIsStatelessAndSkipsLinear) {
  const scene::Scene scene = wall_and_lamp(0.4f, 30, 0.2f), bright = wall_and_lamp(5000, 0, 0);
  const passes::ImageOutputs outputs(wire::kColorSrgb8 | wire::kColorLinearF16);
  const state::PoseState poses(scene);
  passes::View view = first_camera_view(scene, poses, kSize);
  settings::DrawSettings settings = metered_settings(4), fixed = bloom_settings(0, 4);
  settings.post.bloom = fixed.post.bloom = 0.2f;
  RenderBench alone(scene, kSize, settings), unmetered(scene, kSize, fixed);
  const Taken taken = alone.take(poses, view, outputs), plain = unmetered.take(poses, view, outputs);
  EXPECT_EQ(taken.plane<uint64_t>(wire::kColorLinearF16), plain.plane<uint64_t>(wire::kColorLinearF16));
  EXPECT_NE(taken.image.rgba8, plain.image.rgba8);
  RenderBench used(bright, {64, 48}, settings);
  (void)used.draw_at_rest();
  used.renderer().set_scene(scene);
  used.set_size(kSize);
  EXPECT_EQ(used.draw(poses, view).rgba8, taken.image.rgba8);
  // Bloom reads the metered exposure, too: the image of the same exposure as a number is the same.
  const double factor = 0.18 / std::exp(std::log(0.4) + 0.15 / 0.9 * std::log(30 / 0.4));
  fixed.post.exposure = static_cast<float>(factor);
  // The lamp's share in whole pixels differs a little from its area.
  EXPECT_LE(largest_difference(drawn(scene, fixed), taken.image), 4);
  // A camera with its own exposure keeps it.
  view.exposure = 1;
  EXPECT_EQ(used.draw(poses, view).rgba8, unmetered.draw(poses, view).rgba8);
  EXPECT_FALSE(used.renderer().can_take(passes::ImageOutputs(wire::kColorSrgb8), 2));
}

TEST_F(PostEffects, BlackImageKeepsExposure) {
  SceneBuilder builder = plane_camera();
  scene::Material unlit = matte({0.5f, 0.25f, 1});
  unlit.unlit = true;
  builder.mesh_node("sign", builder.quad(builder.material(unlit), 0.3f), glm::mat4(1));
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = metered_settings(), fixed = bloom_settings(0);
  settings.post.bloom = fixed.post.bloom = 0.3f;
  settings.post.exposure = fixed.post.exposure = 7;
  EXPECT_EQ(drawn(scene, settings).rgba8, drawn(scene, fixed).rgba8);
  EXPECT_EQ(drawn(wall_and_lamp(0, 0, 0), settings).rgba8, drawn(wall_and_lamp(0, 0, 0), fixed).rgba8);
}

TEST_F(PostEffects, OnePixelImagesWork) {
  const scene::Scene scene = lamps(false);
  settings::DrawSettings settings = metered_settings(4);
  settings.post.bloom = 0.5f;
  for (const VkExtent2D size : {VkExtent2D{1, 1}, VkExtent2D{2, 1}, VkExtent2D{1, 37}})
    EXPECT_EQ(drawn(scene, settings, size).rgba8.size(), 4 * size.width * size.height);
}

}  // namespace
}  // namespace fire3dv::test
