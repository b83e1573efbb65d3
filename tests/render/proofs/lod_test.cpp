// Render test of cluster levels of detail (LOD): images with and without LOD agree within the tolerance, from
// near to far, with shadows and under stretching and mirroring transforms. Far away LOD draws far fewer
// clusters.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/derived/loaded_scene.h"
#include "tests/render/support/proof_bench.h"
#include "tests/support/image_compare.h"

namespace fire3dv::test {
namespace {

using glm::mat4;
using glm::vec3;
using settings::LevelsOfDetail;

constexpr VkExtent2D kExtent{160, 120};

settings::DrawSettings settings(uint32_t samples, settings::LevelsOfDetail levels, bool hybrid = true) {
  settings::DrawSettings settings = shadowed_by(settings::ShadowMethod::ray, hybrid, samples);
  settings.environment_intensity = 1;
  settings.levels_of_detail = levels;
  return settings;
}

// Dense bodies on a ground under a sun: textured, bumpy, flat-shaded, stretched and mirrored.
scene::Scene bodies() {
  SceneBuilder builder;
  scene::Material checked = matte({1, 1, 1});
  checked.base_color_texture.texture = builder.texture(64, 32, true, [](float u, float v) {
    const bool dark = (static_cast<int>(u * 16) + static_cast<int>(v * 8)) % 2 == 1;
    return dark ? glm::vec4(0.2f, 0.3f, 0.6f, 1) : glm::vec4(0.8f, 0.7f, 0.5f, 1);
  });
  const uint32_t textured = builder.material(checked), grey = builder.material(matte({0.6f, 0.6f, 0.6f})),
                 red = builder.material(matte({0.7f, 0.2f, 0.15f}));
  builder.mesh_node("ground", builder.quad(grey, 40), mat4(1));
  const uint32_t ball = builder.sphere(textured, 0.8f, 192);
  const uint32_t bumpy = builder.lathe(
      red,
      [](float theta, float phi) {
        const float r = 0.8f * (1 + 0.15f * std::sin(5 * theta) * std::sin(theta) * std::sin(6 * phi));
        return r * vec3(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
      },
      128);
  builder.mesh_node("ball", ball, at({-1, 0.8f, 0}));
  builder.mesh_node("bumpy", bumpy, at({1, 0.9f, 0}));
  builder.mesh_node("stretched", ball,
                    at({0, 0.6f, -2}) * glm::rotate(mat4(1), 0.7f, vec3(0, 0.6f, 0.8f)) *
                        glm::scale(mat4(1), vec3(-1.5f, 0.4f, 0.7f)));
  for (int i = 0; i < 6; ++i) {
    builder.mesh_node("small", i % 2 == 0 ? ball : bumpy,
                      at({static_cast<float>(i) - 2.5f, 0.25f, 1.6f}) * glm::scale(mat4(1), vec3(0.3f)));
  }
  builder.light_node(sun({1, 1, 1}, 2.5f), shining_towards({-0.5f, -1, -0.4f}));
  return builder.build();
}

// Returns the fraction of pixels whose colour lies outside of the range of the reference's 3x3 neighbourhood.
// A surface displaced by less than a pixel stays within it.
double share_not_explained(const sinks::FrameImage& image, const sinks::FrameImage& reference) {
  const int delta = Tolerance::colour().max_channel_delta();
  uint32_t count = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      glm::ivec3 low(255), high(0);
      for (uint32_t v = y - (y > 0); v <= std::min(y + 1, image.height - 1); ++v) {
        for (uint32_t u = x - (x > 0); u <= std::min(x + 1, image.width - 1); ++u) {
          low = glm::min(low, pixel(reference, u, v));
          high = glm::max(high, pixel(reference, u, v));
        }
      }
      const glm::ivec3 here = pixel(image, x, y);
      count += glm::any(glm::lessThan(here, low - delta)) || glm::any(glm::greaterThan(here, high + delta));
    }
  }
  return static_cast<double>(count) / (static_cast<double>(image.width) * image.height);
}

class Levels : public ValidationIsSilent {
 protected:
  // Compares images along a zoom from near to far. Returns the cluster counts at the end, with and without
  // LOD.
  static std::pair<uint32_t, uint32_t> zoom(const settings::DrawSettings& drawn, int steps, float factor) {
    const scene::Scene scene = bodies();
    settings::DrawSettings all = drawn;
    all.levels_of_detail = LevelsOfDetail::off;
    ProofBench with(kExtent, drawn), without(kExtent, all);
    with.show(scene);
    without.show(scene);
    double different = 0;
    for (int i = 0; i < steps; ++i) {
      const vec3 eye = vec3(0.3f, 0.35f, 1) * (2.2f * std::pow(factor, static_cast<float>(i)));
      const sinks::FrameImage image = with.draw(eye, {0, 0.5f, 0}, 0.8f);
      const sinks::FrameImage reference = without.draw(eye, {0, 0.5f, 0}, 0.8f);
      EXPECT_LE(share_not_explained(image, reference), Tolerance::colour().max_share_over_delta())
          << "step " << i;
      const ImageDifference d = difference_of(image, reference, Tolerance::colour());
      different += static_cast<double>(d.pixels_over_delta) / static_cast<double>(d.pixels);
    }
    // With one sample the images agree within the tolerance on average, edges included. With several samples
    // the coverage merge depends on the triangle size.
    if (drawn.samples == 1) {
      EXPECT_LE(different / steps, Tolerance::colour().max_share_over_delta());
    }
    return {all_clusters_of(with), all_clusters_of(without)};
  }

  // Counts the clusters from the last position without culling.
  static uint32_t all_clusters_of(ProofBench& bench) {
    settings::DrawSettings settings = bench.renderer().settings().draw();
    settings.cull = settings::Cull::off;
    bench.renderer().apply(settings);
    for (int i = 0; i < 4; ++i) bench.draw(vec3(20, 23, 66), {0, 0.5f, 0}, 0.8f);  // counters come later
    return bench.renderer().counts().clusters;
  }
};

TEST_F(Levels, ZoomLooksAsWithEveryTriangle) {
  for (uint32_t samples : {1u, 4u}) {
    const auto [with, without] = samples == 1
                                     ? zoom(settings(samples, LevelsOfDetail::everywhere), 40, 1.09f)
                                     : zoom(settings(samples, LevelsOfDetail::everywhere), 20, 1.19f);
    EXPECT_GT(with, 0u);
    EXPECT_LT(with, without / 5) << "far away too much is drawn";
  }
}

TEST_F(Levels, ShadowsStayPerTechnique) {
  settings::DrawSettings maps = settings(1, LevelsOfDetail::everywhere);
  maps.shadows.method = settings::ShadowMethod::map;
  zoom(maps, 8, 1.5f);
  zoom(settings(1, LevelsOfDetail::camera, false), 8, 1.5f);
}

// Mean difference of the channels from an image of 8 times the width and height, averaged to its size.
double error_of(const sinks::FrameImage& image, const sinks::FrameImage& large) {
  double sum = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      glm::dvec3 mean(0);
      for (uint32_t v = 0; v < 64; ++v) mean += glm::dvec3(pixel(large, 8 * x + v % 8, 8 * y + v / 8)) / 64.0;
      const glm::dvec3 difference = glm::abs(glm::dvec3(pixel(image, x, y)) - mean);
      sum += (difference.r + difference.g + difference.b) / 3;
    }
  }
  return sum / (static_cast<double>(image.width) * image.height);
}

// A small image with the levels of surfaces is as near to the truth as one of all triangles.
TEST_F(Levels, SmallImagesNeedSurfacesAlone) {
  constexpr VkExtent2D kSmall{48, 36}, kLarge{8 * kSmall.width, 8 * kSmall.height};
  const scene::Scene scene = bodies();
  const vec3 eye(1.2f, 1.4f, 4);
  uint32_t clusters[3] = {};
  double errors[3] = {};
  ProofBench large(kLarge, settings(1, LevelsOfDetail::off));
  large.show(scene);
  const sinks::FrameImage reference = large.draw(eye, {0, 0.5f, 0}, 0.8f);
  const LevelsOfDetail levels[] = {LevelsOfDetail::off, LevelsOfDetail::camera, LevelsOfDetail::surface};
  for (size_t i = 0; i < std::size(levels); ++i) {
    ProofBench bench(kSmall, settings(1, levels[i]));
    bench.show(scene);
    errors[i] = error_of(bench.draw(eye, {0, 0.5f, 0}, 0.8f), reference);
    for (int more = 0; more < 4; ++more) bench.draw(eye, {0, 0.5f, 0}, 0.8f);  // counters come later
    clusters[i] = bench.renderer().counts().clusters;
  }
  EXPECT_LT(errors[2], 1.05 * errors[0]);
  EXPECT_LT(clusters[1], clusters[0]);
  EXPECT_LT(2 * clusters[2], clusters[1]) << clusters[0] << " without levels";
  EXPECT_GT(clusters[2], 0u);
}

// Rays intersect LOD 0 while the camera sees a coarser surface: lit surfaces must not shadow themselves.
TEST_F(Levels, NoSurfaceShadowsItself) {
  SceneBuilder builder;
  const uint32_t white = builder.material(matte({0.8f, 0.8f, 0.8f}));
  builder.mesh_node("ball", builder.sphere(white, 1, 192), mat4(1));
  builder.light_node(sun({1, 1, 1}, 3), shining_towards({0, 0, -1}));
  const scene::Scene scene = builder.build();
  settings::DrawSettings lit = settings(1, LevelsOfDetail::camera, false);
  lit.environment_intensity = 0;
  ProofBench bench(kExtent, lit);
  bench.show(scene);
  for (float distance : {4.0f, 9.0f, 20.0f, 45.0f}) {
    const sinks::FrameImage image = bench.draw({0, 0, distance}, {0, 0, 0}, 0.5f);
    // Checks pixels well inside of the lit, visible side.
    const float radius = 0.7f / distance / std::tan(0.25f) * static_cast<float>(kExtent.height) / 2;
    uint32_t looked_at = 0;
    for (uint32_t y = 0; y < kExtent.height; ++y) {
      for (uint32_t x = 0; x < kExtent.width; ++x) {
        const glm::vec2 from_center =
            glm::vec2(x, y) + 0.5f - 0.5f * glm::vec2(kExtent.width, kExtent.height);
        if (glm::length(from_center) > radius) continue;
        ++looked_at;
        ASSERT_GT(pixel(image, x, y).r, 60) << x << ", " << y << " from " << distance << " m";
      }
    }
    EXPECT_GT(looked_at, 10u);
  }
}

}  // namespace
}  // namespace fire3dv::test
