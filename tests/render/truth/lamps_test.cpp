// Render test of lamps beside the lens, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/render/support/path_bench.h"
#include "tests/render/support/proof_bench.h"
#include "tests/render/support/walls.h"

namespace fire3dv::test {
namespace {

class Lamps : public ValidationIsSilent {};

// Radiance of a white wall under lamps of 1 cd in the plane z = 0, seen at a point of the wall.
double lit(const std::vector<glm::dvec3>& lamps, const glm::dvec3& point, double spread, double albedo) {
  double sum = 0;
  for (const glm::dvec3& lamp : lamps) {
    const glm::dvec3 ray = point - lamp;
    const double cosine = -ray.z / glm::length(ray);
    sum += std::exp(-spread * (1 - cosine)) * cosine / glm::dot(ray, ray);
  }
  return sum * albedo / std::numbers::pi;
}

TEST_F(Lamps, LampsFallOffByDistanceAndAngle) {
  constexpr VkExtent2D kSize{48, 32};
  constexpr float kFov = 1.6f;
  constexpr double kAlbedo = 0.5, kSpread = 2.767;
  for (const char* const how : {"raster", "forward", "effects", "paths"}) {
    for (const uint32_t count : {1u, 2u, 3u}) {
      if ((*how == 'r') == (count == 2)) continue;
      settings::DrawSettings settings = plain_settings();
      settings.environment_intensity = 0;
      settings.lamps = {.count = count, .intensity_cd = 1, .spread = float{kSpread}, .offset_mm = 8};
      if (*how == 'f') settings.raster = settings::RasterPath::forward;
      if (*how == 'e') settings.ray_effects.on.reflections = true;
      if (*how == 'p') settings.path = settings::PathSettings{.samples_per_pixel = 4, .bounces = 0};
      std::vector<glm::dvec3> lamps;
      for (uint32_t lamp = 0; lamp < count; ++lamp) {
        const double angle = 2 * std::numbers::pi * lamp / count;
        lamps.emplace_back(0.008 * std::cos(angle), 0.008 * std::sin(angle), 0);
      }
      for (const double distance_m : {0.04, 0.08}) {
        if (*how != 'r' && distance_m > 0.05) continue;
        const scene::Scene scene = wall(lambert(glm::vec3(kAlbedo)), static_cast<float>(distance_m), kFov);
        if (*how == 'f') {
          // The forward path has no linear plane; bytes of a linear sensor stand for it.
          settings.post.optics.response = 1;
          settings.post.exposure = 0.0025f;
          const sinks::FrameImage image = drawn(scene, settings, kSize);
          for (uint32_t x = 0; x < kSize.width; x += 5) {
            const glm::dvec3 point = point_at({x, 11}, kSize, distance_m, double{kFov});
            EXPECT_NEAR(pixel(image, x, 11).g, 255 * 0.0025 * lit(lamps, point, kSpread, kAlbedo), 1.01)
                << how << count << distance_m << x;
          }
          continue;
        }
        const std::vector<glm::dvec3> light = linear_image(scene, kSize, settings);
        for (uint32_t y = 0; y < kSize.height; y += 3) {
          for (uint32_t x = 0; x < kSize.width; x += 5) {
            const double wanted =
                lit(lamps, point_at({x, y}, kSize, distance_m, double{kFov}), kSpread, kAlbedo);
            // Paths also average over the pixel's area.
            EXPECT_NEAR(light[y * kSize.width + x].g, wanted, (*how == 'p' ? 0.06 : 0.01) * wanted)
                << how << count << " " << distance_m << " " << x << ", " << y;
          }
        }
      }
    }
  }
}

TEST_F(Lamps, LampsCastShadowsAndFollowTheCamera) {
  constexpr VkExtent2D kSize{64, 48};
  for (const bool traces : {false, true}) {
    for (const float moved : {0.0f, 0.5f}) {
      SceneBuilder builder;
      builder.camera_node("camera", {moved, 0, 0}, {moved, 0, -1}, 1);
      const uint32_t white = builder.material(lambert(glm::vec3(0.8f)));
      builder.mesh_node("wall", builder.quad(white, 1), wall_at(0.1f));
      // Half way to the wall, so that its shadow from a lamp at the right lies as far to the left.
      builder.mesh_node("bar", builder.quad(white, 0.004f), wall_at(0.05f, {moved, 0}));
      const scene::Scene scene = builder.build();
      settings::DrawSettings settings = shadowed_by(settings::ShadowMethod::automatic);
      settings.environment_intensity = 0;
      settings.lamps = {.count = 1, .intensity_cd = 1, .spread = 0, .offset_mm = 20};
      if (traces) settings.path = settings::PathSettings{.samples_per_pixel = 4, .bounces = 0};
      const std::vector<glm::dvec3> light = linear_image(scene, kSize, settings);
      const double px_of_m = kSize.height / (2 * 0.1 * std::tan(0.5));  // on the wall
      const auto at = [&](double x_m) {
        return light[kSize.height / 2 * kSize.width + static_cast<size_t>(kSize.width / 2 + x_m * px_of_m)].g;
      };
      EXPECT_EQ(at(-0.020), 0) << traces << moved;
      for (const double lit_m : {-0.036, 0.02, 0.03}) EXPECT_GT(at(lit_m), 10) << traces << moved << lit_m;
    }
  }
}

TEST_F(Lamps, CamerasOfOneScopeShareItsLamps) {
  constexpr VkExtent2D kSize{48, 32};
  SceneBuilder builder;
  builder.mesh_node("wall", builder.quad(builder.material(lambert(glm::vec3(0.8f))), 1), wall_at(0.05f));
  builder.camera_node("left", {-0.0025f, 0, 0}, {-0.0025f, 0, -1}, 1);
  builder.camera_node("right", {0.0025f, 0, 0}, {0.0025f, 0, -1}, 1);
  scene::Scene scene = builder.build();
  settings::DrawSettings settings = plain_settings();
  settings.environment_intensity = 0;
  settings.lamps = {.count = 2, .intensity_cd = 1, .spread = 2.767f, .offset_mm = 8};
  const double shift_px = 0.0025 * kSize.height / (2 * 0.05 * std::tan(0.5));
  for (const bool is_scope : {false, true}) {
    if (is_scope) scene.nodes[1].parent = scene.nodes[2].parent = 0;
    const state::PoseState poses(scene);
    RenderBench bench(scene, kSize, settings);
    std::vector<double> brightest;
    for (const uint32_t node : {1u, 2u}) {
      passes::View view = passes::make_view(scene.cameras[scene.nodes[node].camera],
                                            poses.world_from_node(node), float{kSize.width} / kSize.height);
      view.camera = scene.nodes[node].name;
      passes::ImageOutputs outputs;
      outputs.add(wire::kColorLinearF16);
      const std::vector<uint64_t> row =
          bench.take(poses, view, outputs).plane<uint64_t>(wire::kColorLinearF16);
      double sum = 0, moment = 0;
      for (uint32_t i = 0; i < row.size(); ++i) {
        const double value = glm::unpackHalf4x16(row[i]).g;
        sum += value;
        moment += value * (i % kSize.width + 0.5 - 0.5 * kSize.width);
      }
      brightest.push_back(moment / sum);
    }
    // The light of one scope is between the eyes, that of two cameras before each of them.
    EXPECT_GT(brightest[0] - brightest[1], is_scope ? 0.2 * shift_px : -0.01);
    EXPECT_NEAR(brightest[0] + brightest[1], 0, 0.02);
    if (!is_scope) {
      EXPECT_NEAR(brightest[0], 0, 0.02);
    }
  }
}

TEST_F(Lamps, OrthographicCamerasHaveThemToo) {
  constexpr VkExtent2D kSize{48, 32};
  constexpr double kDistanceM = 0.05, kHalfHeightM = 0.03, kAlbedo = 0.5;
  scene::Scene scene = wall(lambert(glm::vec3(kAlbedo)), kDistanceM);
  scene.cameras[0].orthographic = true;
  scene.cameras[0].half_extent_m = glm::vec2(1.5 * kHalfHeightM, kHalfHeightM);
  settings::DrawSettings settings = plain_settings();
  settings.environment_intensity = 0;
  settings.lamps = {.count = 1, .intensity_cd = 1, .spread = 2, .offset_mm = 8};
  const std::vector<glm::dvec3> light = linear_image(scene, kSize, settings);
  for (uint32_t y = 0; y < kSize.height; y += 3) {
    for (uint32_t x = 0; x < kSize.width; x += 5) {
      const glm::dvec3 point{(x - 23.5) / 16 * kHalfHeightM, (15.5 - y) / 16 * kHalfHeightM, -kDistanceM};
      const double wanted = lit({glm::dvec3(0.008, 0, 0)}, point, 2, kAlbedo);
      EXPECT_NEAR(light[y * kSize.width + x].g, wanted, 0.01 * wanted) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace fire3dv::test
