// Determinism test of images: the same scene gives the same bytes in repeated frames, in another renderer,
// and with or without culling.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

// A scene with overlap, equal depths, alpha masks, mirrored nodes, and three kinds of light. Objects are
// large and small, behind the eye, and across the near plane.
scene::Scene crowded() {
  SceneBuilder builder;
  scene::Material leaf = matte({0.3f, 0.8f, 0.3f});
  leaf.alpha_mode = scene::AlphaMode::mask;
  leaf.double_sided = true;
  leaf.base_color_texture.texture = builder.texture(32, 32, true, [](float u, float v) {
    return glm::vec4(1, 1, 1, glm::fract(8 * u) > 0.5f && glm::fract(8 * v) > 0.3f ? 1 : 0);
  });
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f})),
                 red = builder.material(matte({0.9f, 0.2f, 0.1f}));
  const uint32_t leaves = builder.material(leaf);
  builder.mesh_node("ground", builder.quad(white, 200), glm::mat4(1));
  builder.mesh_node("same_ground", builder.quad(red, 1), glm::mat4(1));  // depth bit-identical to the ground
  const uint32_t ball = builder.sphere(red, 0.3f, 40), box = builder.box(white, {0.3f, 0.3f, 0.3f});
  const uint32_t sheet = builder.quad(leaves, 0.2f);
  for (int i = 0; i < 16; ++i) {
    const float angle = 2.3999632f * static_cast<float>(i), r = 0.35f * std::sqrt(static_cast<float>(i));
    const glm::mat4 place = at({r * std::cos(angle), 0.25f, r * std::sin(angle)});
    const glm::mat4 turn = glm::rotate(glm::mat4(1), angle, glm::vec3(1, 2, 3) / std::sqrt(14.0f));
    const glm::vec3 size = i % 3 == 0   ? glm::vec3(-1, 1, 1)
                           : i % 3 == 1 ? glm::vec3(1, 0.3f, 2)
                                        : glm::vec3(1);
    builder.mesh_node("thing" + std::to_string(i),
                      i % 4 == 0   ? box
                      : i % 4 == 1 ? sheet
                                   : ball,
                      place * turn * glm::scale(glm::mat4(1), size));
  }
  builder.light_node(sun({1, 0.9f, 0.8f}, 1.5f), shining_towards({-0.5f, -1, -0.4f}));
  scene::Light lamp;
  lamp.intensity = 2;
  lamp.radius_m = 0.05f;
  builder.light_node(lamp, at({0.3f, 1.1f, 0.4f}));
  lamp.type = scene::LightType::spot;
  lamp.radius_m = 0;
  builder.light_node(lamp, shining_towards({0.2f, -1, 0}, {-0.5f, 2, 0.3f}));
  builder.camera_node("camera", {0.9f, 0.6f, 1.1f}, {0, 0.1f, 0});
  return builder.build();
}

class Determinism : public ValidationIsSilent {};

TEST_F(Determinism, FiftyImagesAndAnotherRenderer) {
  const scene::Scene scene = crowded();
  for (uint32_t samples : {1u, 4u}) {
    SCOPED_TRACE(samples);
    settings::DrawSettings settings = shadowed_by(settings::ShadowMethod::ray, true, samples);
    settings.environment_intensity = 0.5f;
    RenderBench bench(scene, {64, 48}, settings);
    const sinks::FrameImage first = bench.draw_at_rest();
    for (int i = 1; i < (samples == 4 ? 50 : 10); ++i) {
      ASSERT_TRUE(matches_image(bench.draw_at_rest(), first, "determinism_again", Tolerance::exact()))
          << "image " << i;
    }
    RenderBench other(scene, {64, 48}, settings);
    EXPECT_TRUE(matches_image(other.draw_at_rest(), first, "determinism_other", Tolerance::exact()));
  }
}

TEST_F(Determinism, CullingMakesNoDifference) {
  const scene::Scene scene = crowded();
  for (uint32_t samples : {1u, 4u}) {
    for (auto [method, hybrid] :
         {std::pair(settings::ShadowMethod::ray, true), std::pair(settings::ShadowMethod::ray, false),
          std::pair(settings::ShadowMethod::map, false)}) {
      SCOPED_TRACE(testing::Message()
                   << samples << " samples, method " << static_cast<int>(method) << ", " << hybrid);
      settings::DrawSettings settings = shadowed_by(method, hybrid, samples);
      settings.cull = settings::Cull::hidden;
      ProofBench culled({64, 48}, settings);
      settings.cull = settings::Cull::off;
      ProofBench whole({64, 48}, settings);
      culled.show(scene);
      whole.show(scene);
      // The renderer starts without history for the first view, has another view's history for the next ones,
      // and the same view's history for the last.
      for (int i : {0, 1, 2, 3, 3}) {
        const float angle = 1.570796f * static_cast<float>(i);
        const glm::vec3 eye(1.6f * std::cos(angle), 0.1f + 0.4f * static_cast<float>(i),
                            1.6f * std::sin(angle));
        ASSERT_TRUE(matches_image(culled.draw(eye, {0, 0.2f, 0}), whole.draw(eye, {0, 0.2f, 0}),
                                  "determinism_cull", Tolerance::exact()))
            << "view " << i;
      }
    }
  }
}

// A wall occludes half of a crowd; in the other half one distant ball is smaller than the sample spacing.
TEST_F(Determinism, WhatIsHiddenIsLeftOut) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  const uint32_t ball = builder.sphere(white, 0.1f, 48);
  for (int i = 0; i < 40; ++i) {
    const float x = 0.12f * static_cast<float>(i % 20 - 10) + 0.06f, z = i < 20 ? 0.0f : -0.3f;
    builder.mesh_node("ball" + std::to_string(i), ball, at({x, 0.1f, z}));
  }
  builder.mesh_node("wall", builder.box(white, {1.0f, 0.5f, 0.01f}), at({-1.1f, 0.2f, 0.5f}));
  builder.camera_node("camera", {0, 0.3f, 2.2f}, {0, 0.1f, 0});
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = plain_settings();
  settings.levels_of_detail = settings::LevelsOfDetail::off;  // coarser clusters extend beyond a ball
  const auto clusters_of = [&](settings::Cull cull, sinks::FrameImage& image) {
    settings.cull = cull;
    RenderBench bench(scene, {160, 120}, settings);
    for (int i = 0; i < 6; ++i) image = bench.draw_at_rest();  // until the counters are read back
    return bench.renderer().counts();
  };
  sinks::FrameImage all, in_view, seen;
  const uint32_t all_clusters = clusters_of(settings::Cull::off, all).clusters;
  const uint32_t view_clusters = clusters_of(settings::Cull::view, in_view).clusters;
  const passes::RenderCounts drawn = clusters_of(settings::Cull::hidden, seen);
  EXPECT_LT(view_clusters, all_clusters * 9 / 10) << "the far sides of balls are turned away";
  EXPECT_LT(drawn.clusters, view_clusters * 3 / 4) << "a wall hides nearly half of them";
  EXPECT_GT(drawn.clusters, view_clusters / 4);
  EXPECT_EQ(drawn.late_clusters, 0u) << "nothing has moved";
  EXPECT_TRUE(matches_image(in_view, all, "determinism_view", Tolerance::exact()));
  EXPECT_TRUE(matches_image(seen, all, "determinism_hidden", Tolerance::exact()));
}

// A dense ball so far away that it lies between the samples of one pixel.
TEST_F(Determinism, TrianglesBetweenSamplesAreDropped) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  builder.mesh_node("far", builder.sphere(white, 0.01f, 64), at({0.02f, 0.01f, -20}));
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1});
  const scene::Scene scene = builder.build();
  for (uint32_t samples : {1u, 4u}) {
    settings::DrawSettings settings = plain_settings();
    settings.samples = samples;
    settings.cull = settings::Cull::view;
    RenderBench culled(scene, {64, 48}, settings);
    sinks::FrameImage image;
    for (int i = 0; i < 6; ++i) image = culled.draw_at_rest();
    EXPECT_EQ(culled.renderer().counts().clusters, 0u) << samples;
    settings.cull = settings::Cull::off;
    RenderBench whole(scene, {64, 48}, settings);
    EXPECT_TRUE(matches_image(image, whole.draw_at_rest(), "determinism_between", Tolerance::exact()));
  }
}

// More triangles lie behind the eye than the list of near-plane triangles holds initially.
TEST_F(Determinism, FirstImageIsComplete) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({1, 1, 1}));
  builder.mesh_node("fine", builder.sphere(white, 1, 512), glm::mat4(1));
  const uint32_t ball = builder.sphere(white, 0.3f, 32);
  builder.mesh_node("seen", ball, at({0, 0, -3}));
  builder.mesh_node("ground", builder.quad(white, 50), at({0, -1.5f, 0}));
  builder.light_node(sun({1, 1, 1}, 2), shining_towards({-0.3f, -1, -0.4f}));
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1});
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = plain_settings();
  settings.cull = settings::Cull::off;
  RenderBench whole(scene, {64, 48}, settings);
  const sinks::FrameImage first = whole.draw_at_rest();
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(matches_image(whole.draw_at_rest(), first, "determinism_warm", Tolerance::exact()));
  }
  settings.cull = settings::Cull::hidden;
  RenderBench culled(scene, {64, 48}, settings);
  EXPECT_TRUE(matches_image(culled.draw_at_rest(), first, "determinism_first", Tolerance::exact()));
}

}  // namespace
}  // namespace fire3dv::test
