// Render test of the sun of an environment image: its shadow, against paths, by each technique; what turns,
// scales and switches it off.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "renderer/passes/resources/gpu_scene.h"
#include "renderer/scene/textures/environment_sun.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kSunSize{48, 36};
const glm::vec3 kToSun = glm::normalize(glm::vec3(1, 1, 0));

std::shared_ptr<const scene::EnvironmentImage> sunny_sky() {
  return std::make_shared<scene::EnvironmentImage>(
      scene::make_environment(256, 128, [](const glm::vec3& direction) {
        const bool is_sun = glm::dot(direction, kToSun) > std::cos(0.03f);
        return is_sun ? glm::vec3(600, 500, 400)
                      : (direction.y > 0 ? glm::vec3(0.2f, 0.3f, 0.5f) : glm::vec3(0.1f));
      }));
}

// A square plate at a height of 1 m over a white floor: its shadow is around x = -1.
scene::Scene plate_over_floor() {
  SceneBuilder builder;
  builder.mesh_node("floor", builder.quad(builder.material(lambert(glm::vec3(0.8f))), 30), glm::mat4(1));
  builder.mesh_node("plate", builder.box(builder.material(lambert(glm::vec3(0))), {0.5f, 0.02f, 0.5f}),
                    at({0, 1, 0}));
  builder.camera_node("camera", {0, 5, 5}, {0, 0, 0});
  return builder.build();
}

settings::DrawSettings in_sky(const std::shared_ptr<const scene::EnvironmentImage>& sky) {
  settings::DrawSettings settings;
  settings.environment = sky;
  settings.background.show_environment = true;
  settings.post.fxaa = false;
  return settings;
}

class EnvironmentSun : public ValidationIsSilent {
 protected:
  std::vector<glm::dvec3> draw(const settings::DrawSettings& settings) {
    return linear_image(scene_, kSunSize, settings);
  }
  // Mean of 3 x 3 pixels around a point of the floor.
  glm::dvec3 floor_at(const std::vector<glm::dvec3>& image, float x, float z) const {
    const state::PoseState poses(scene_);
    const glm::vec4 clip = first_camera_view(scene_, poses, kSunSize).clip_from_world * glm::vec4(x, 0, z, 1);
    const auto column = static_cast<size_t>((clip.x / clip.w * 0.5f + 0.5f) * kSunSize.width);
    const auto row = static_cast<size_t>((clip.y / clip.w * 0.5f + 0.5f) * kSunSize.height);
    glm::dvec3 sum(0);
    for (size_t dy = row - 1; dy <= row + 1; ++dy)
      for (size_t dx = column - 1; dx <= column + 1; ++dx) sum += image[dy * kSunSize.width + dx] / 9.0;
    return sum;
  }

  const std::shared_ptr<const scene::EnvironmentImage> sky_ = sunny_sky();
  const scene::Scene scene_ = plate_over_floor();
};

TEST_F(EnvironmentSun, ShadowAndLitFloorEqualPaths) {
  settings::DrawSettings settings = in_sky(sky_);
  settings::DrawSettings traced = settings;
  traced.path = settings::PathSettings{.samples_per_pixel = 256, .bounces = 0};
  const std::vector<glm::dvec3> paths = draw(traced);
  const glm::dvec3 lit_truth = floor_at(paths, 1.3f, 0), dark_truth = floor_at(paths, -1, 0);
  EXPECT_LT(dark_truth.r, 0.4 * lit_truth.r);
  const auto split = scene::split_sun(*sky_);
  ASSERT_TRUE(split);
  const glm::dvec3 of_sun =
      0.8 / kPi * static_cast<double>(kToSun.y) * glm::dvec3(split->sun.illuminance_lux);
  for (const settings::ShadowMethod method :
       {settings::ShadowMethod::automatic, settings::ShadowMethod::map}) {
    settings.shadows.method = method;
    const std::vector<glm::dvec3> drawn = draw(settings);
    const glm::dvec3 lit = floor_at(drawn, 1.3f, 0), dark = floor_at(drawn, -1, 0);
    for (int c = 0; c < 3; ++c) {
      // Bodies hide the sky from the floor in paths alone.
      EXPECT_NEAR(lit[c] / lit_truth[c], 1, 0.04);
      EXPECT_NEAR((lit[c] - dark[c]) / of_sun[c], 1, 0.01);
    }
  }
}

TEST_F(EnvironmentSun, OffKeepsItInTheImage) {
  settings::DrawSettings settings = in_sky(sky_);
  settings.environment_sun = false;
  RenderBench bench(scene_, kSunSize, settings);
  const std::vector<glm::dvec3> whole = linear_image(bench, scene_, kSunSize);
  EXPECT_FALSE(bench.renderer().gpu_scene().sun);
  EXPECT_EQ(bench.renderer().gpu_scene().light_count, 0u);
  const glm::dvec3 lit = floor_at(whole, 1.3f, 0), below = floor_at(whole, -1, 0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(below[c], lit[c], 1e-6);
  // The lit floor has the same light either way, and the sky shows the sun's disc.
  settings.environment_sun = true;
  const glm::dvec3 split = floor_at(draw(settings), 1.3f, 0);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(split[c] / lit[c], 1, 0.02);
}

TEST_F(EnvironmentSun, SkyWithoutSunHasNoLight) {
  const auto overcast = std::make_shared<scene::EnvironmentImage>(scene::make_environment(
      256, 128, [](const glm::vec3& direction) { return glm::vec3(1 + std::max(direction.y, 0.0f)); }));
  settings::DrawSettings settings = in_sky(overcast);
  RenderBench bench(scene_, kSunSize, settings);
  const std::vector<glm::dvec3> drawn = linear_image(bench, scene_, kSunSize);
  EXPECT_EQ(bench.renderer().gpu_scene().light_count, 0u);
  settings.environment_sun = false;
  EXPECT_EQ(drawn, draw(settings));
}

TEST_F(EnvironmentSun, BackgroundKeepsTheDisc) {
  SceneBuilder builder;
  builder.mesh_node("far", builder.quad(builder.material(lambert(glm::vec3(0.5f))), 0.1f), at({0, -50, 0}));
  builder.camera_node("camera", {0, 0, 0}, kToSun);
  const scene::Scene scene = builder.build();
  settings::DrawSettings settings = in_sky(sky_);
  const std::vector<glm::dvec3> split = linear_image(scene, kSunSize, settings);
  settings.environment_sun = false;
  EXPECT_EQ(split, linear_image(scene, kSunSize, settings));
  EXPECT_GT(split[kSunSize.height / 2 * kSunSize.width + kSunSize.width / 2].r, 100);
}

TEST_F(EnvironmentSun, TurnsAndDimsWithTheEnvironment) {
  settings::DrawSettings settings = in_sky(sky_);
  RenderBench bench(scene_, kSunSize, settings);
  const std::vector<glm::dvec3> first = linear_image(bench, scene_, kSunSize);
  settings.environment_rotation_rad = static_cast<float>(kPi);  // the shadow moves to the other side
  settings.environment_intensity = 0.5f;
  bench.renderer().apply(settings);
  const std::vector<glm::dvec3> turned = linear_image(bench, scene_, kSunSize);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(floor_at(turned, -1.3f, 0)[c] / floor_at(first, 1.3f, 0)[c], 0.5, 0.005);
    EXPECT_NEAR(floor_at(turned, 1, 0)[c] / floor_at(first, -1, 0)[c], 0.5, 0.005);
  }
  // A dark environment has no light at all, and no shadow rays.
  settings.environment_intensity = 0;
  bench.renderer().apply(settings);
  EXPECT_EQ(floor_at(linear_image(bench, scene_, kSunSize), 1.3f, 0), glm::dvec3(0));
}

TEST_F(EnvironmentSun, PathsKeepTheWholeImage) {
  settings::DrawSettings settings = in_sky(sky_);
  settings.path = settings::PathSettings{.samples_per_pixel = 4, .bounces = 1};
  const std::vector<glm::dvec3> with = draw(settings);
  settings.environment_sun = false;
  EXPECT_EQ(with, draw(settings));
}

TEST_F(EnvironmentSun, RayEffectsShowItsShadow) {
  settings::DrawSettings settings = in_sky(sky_);
  settings.ray_effects.on.bounce = settings.ray_effects.on.reflections = true;
  const std::vector<glm::dvec3> drawn = draw(settings);
  settings::DrawSettings traced = in_sky(sky_);
  traced.path = settings::PathSettings{.samples_per_pixel = 256, .bounces = 1};
  const std::vector<glm::dvec3> paths = draw(traced);
  for (const float x : {-1.0f, 1.3f, 2.0f}) {
    const glm::dvec3 found = floor_at(drawn, x, 0), truth = floor_at(paths, x, 0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / truth[c], 1, 0.06) << x;
  }
}

}  // namespace
}  // namespace fire3dv::test
