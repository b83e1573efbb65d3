// Render test of the diffuse bounce among ray effects: against closed forms and paths of one bounce.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>
#include <vector>

#include "tests/render/support/path_bench.h"
#include "tests/render/support/proof_bench.h"
#include "tests/render/support/truth_scenes.h"

namespace fire3dv::test {
namespace {

constexpr VkExtent2D kBounceSize{32, 24};

settings::RayEffects effects(const char* names) {
  settings::RayEffects on;
  EXPECT_TRUE(settings::ray_effects_named(names, on));
  return on;
}

// One renderer for successive scenes.
class Series {
 public:
  explicit Series(const settings::DrawSettings& settings)
      : scene_(std::make_unique<scene::Scene>(SceneBuilder().build())),
        settings_(settings),
        bench_(*scene_, kBounceSize, settings) {}

  void set(float environment_intensity, const char* on = "off", uint32_t rays = 8) {
    settings_.environment_intensity = environment_intensity;
    settings_.ray_effects.on = effects(on);
    settings_.ray_effects.set_rays(rays);
    bench_.renderer().apply(settings_);
  }
  std::vector<glm::dvec3> draw(scene::Scene scene) {
    auto shown = std::make_unique<scene::Scene>(std::move(scene));
    bench_.renderer().set_scene(*shown);
    scene_ = std::move(shown);
    return draw_again();
  }
  std::vector<glm::dvec3> draw_again() { return linear_image(bench_, *scene_, kBounceSize); }

 private:
  std::unique_ptr<scene::Scene> scene_;
  settings::DrawSettings settings_;
  RenderBench bench_;
};

class DiffuseBounce : public ValidationIsSilent {
 protected:
  // A renderer's pipelines take longer than its images.
  static void SetUpTestSuite() {
    settings::DrawSettings settings = path_settings(96, 1);
    settings.environment = constant_environment({0.6f, 0.8f, 1});
    paths_ = std::make_unique<Series>(settings);
    settings.path.reset();
    settings.samples = 1;
    settings.ray_effects.on = effects("bounce");
    drawn_ = std::make_unique<Series>(settings);
  }
  static void TearDownTestSuite() {
    paths_.reset();
    drawn_.reset();
  }
  static Series& drawn() { return *drawn_; }
  static Series& paths() { return *paths_; }

 private:
  static inline std::unique_ptr<Series> drawn_, paths_;
};

// A floor below a square lamp of side 0.5 and radiance 1, which lights one of its sides.
scene::Scene lamp_above_floor(bool faces_floor) {
  SceneBuilder builder;
  builder.mesh_node("floor", builder.quad(builder.material(lambert(glm::vec3(0.75f))), 5), glm::mat4(1));
  scene::Material lamp = lambert(glm::vec3(0));
  lamp.emissive = glm::vec3(1);
  lamp.double_sided = false;
  builder.mesh_node(
      "lamp", builder.quad(builder.material(lamp), 0.25f),
      glm::rotate(at({0, 1, 0}), glm::radians(faces_floor ? 180.0f : 0.0f), glm::vec3(1, 0, 0)));
  builder.camera_node("camera", {0, 0.9f, 0.1f}, {0, 0, 0}, 1.2f);
  return builder.build();
}

// A box of side 2 with coloured walls and a block in it. Closed, or without a ceiling.
scene::Scene room(bool is_closed, int lamps) {
  SceneBuilder builder;
  const auto wall = [&](const char* name, glm::vec3 albedo, glm::vec3 where, float degrees, glm::vec3 axis) {
    builder.mesh_node(name, builder.quad(builder.material(lambert(albedo)), 1),
                      glm::rotate(at(where), glm::radians(degrees), axis));
  };
  wall("floor", glm::vec3(0.7f), {0, -1, 0}, 0, {1, 0, 0});
  wall("back", glm::vec3(0.7f), {0, 0, -1}, 90, {1, 0, 0});
  wall("front", {0.5f, 0.5f, 0.8f}, {0, 0, 1}, -90, {1, 0, 0});
  wall("left", {0.8f, 0.2f, 0.2f}, {-1, 0, 0}, -90, {0, 0, 1});
  wall("right", {0.2f, 0.8f, 0.2f}, {1, 0, 0}, 90, {0, 0, 1});
  if (is_closed) wall("ceiling", glm::vec3(0.7f), {0, 1, 0}, 180, {1, 0, 0});
  builder.mesh_node("block", builder.box(builder.material(lambert({0.6f, 0.6f, 0.3f})), {0.3f, 0.4f, 0.3f}),
                    glm::rotate(at({0.3f, -0.6f, -0.2f}), 0.4f, glm::vec3(0, 1, 0)));
  for (int i = 0; i < lamps; ++i) {
    scene::Light bulb;
    bulb.color = i % 2 ? glm::vec3(1, 0.6f, 0.4f) : glm::vec3(0.5f, 0.7f, 1);
    bulb.intensity = 1 + 0.5f * static_cast<float>(i);
    const float angle = 1.1f * static_cast<float>(i);
    builder.light_node(
        bulb, at({0.5f * std::cos(angle), 0.6f - 0.1f * static_cast<float>(i), 0.5f * std::sin(angle)}));
  }
  builder.camera_node("camera", {-0.3f, 0.3f, 0.95f}, {0.1f, -0.4f, -0.4f}, 1.2f);
  return builder.build();
}

// Mean of each channel, and of the differences of pixels.
void expect_same_light(const std::vector<glm::dvec3>& seen, const std::vector<glm::dvec3>& truth, double mean,
                       double each, const std::string& what) {
  glm::dvec3 sum(0), seen_sum(0), error(0);
  for (size_t i = 0; i < truth.size(); ++i) {
    sum += truth[i];
    seen_sum += seen[i];
    error += glm::abs(seen[i] - truth[i]);
  }
  for (int c = 0; c < 3; ++c) {
    const std::string channel = what + ", channel " + std::to_string(c);
    testing::Test::RecordProperty(
        channel, std::to_string(seen_sum[c] / sum[c]) + ", pixels " + std::to_string(error[c] / sum[c]));
    EXPECT_NEAR(seen_sum[c] / sum[c], 1, mean) << channel;
    EXPECT_LT(error[c] / sum[c], each) << channel;
  }
}

double brightest(const std::vector<glm::dvec3>& pixels) {
  double most = 0;
  for (const glm::dvec3& pixel : pixels) most = std::max({most, pixel.r, pixel.g, pixel.b});
  return most;
}

TEST_F(DiffuseBounce, IntegratingSphereMatchesTwoTerms) {
  // I / (pi R^2) (p + p^2), and p alone without the bounce.
  drawn().set(0, "bounce");
  const double seen = estimate(drawn().draw(integrating_sphere(96))).mean;
  RecordProperty("radiance", std::to_string(seen));
  EXPECT_NEAR(seen, 10 / kPi * 0.75, 0.01 * 10 / kPi * 0.75);
  drawn().set(0, "off");
  EXPECT_NEAR(estimate(drawn().draw_again()).mean, 10 / kPi * 0.5, 0.005 * 10 / kPi * 0.5);
}

// Irradiance of the floor below the lamp, over pi, by quadrature.
double floor_light(glm::dvec2 place) {
  constexpr int kSteps = 24;
  double sum = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const glm::dvec2 lamp = 0.5 * ((glm::dvec2(i % kSteps, i / kSteps) + 0.5) / double(kSteps) - 0.5);
    const double square = 1 + glm::dot(lamp - place, lamp - place);
    sum += 0.25 / (kSteps * kSteps) / (square * square);
  }
  return sum / kPi;
}

TEST_F(DiffuseBounce, EmissiveSquareMatchesFormFactor) {
  drawn().set(0, "bounce", 32);  // few of the rays hit it
  const scene::Scene scene = lamp_above_floor(true);
  const std::vector<glm::dvec3> seen = drawn().draw(scene);
  const state::PoseState poses(scene);
  const passes::View view = first_camera_view(scene, poses, kBounceSize);
  std::vector<glm::dvec3> truth;
  for (uint32_t i = 0; i < kBounceSize.width * kBounceSize.height; ++i) {
    const glm::vec2 ndc((static_cast<float>(i % kBounceSize.width) + 0.5f) / kBounceSize.width * 2 - 1,
                        (static_cast<float>(i / kBounceSize.width) + 0.5f) / kBounceSize.height * 2 - 1);
    const glm::vec3 ray =
        view.world_from_ndc_x * ndc.x + view.world_from_ndc_y * ndc.y + view.world_from_ndc_origin;
    const glm::vec3 place = view.eye_world - ray * (view.eye_world.y / ray.y);
    truth.emplace_back(0.75 * floor_light({place.x, place.z}));
  }
  EXPECT_NEAR(floor_light({0, 0}) * 0.75, 0.05511, 2e-4) << "the form factor below its middle";
  expect_same_light(seen, truth, 0.02, 0.1, "floor");
  EXPECT_EQ(brightest(drawn().draw(lamp_above_floor(false))), 0) << "its back is dark";
}

TEST_F(DiffuseBounce, RoomsMatchOneBouncePaths) {
  for (const int lamps : {1, 6}) {
    drawn().set(0, "bounce");
    paths().set(0);
    const scene::Scene scene = room(true, lamps);
    expect_same_light(drawn().draw(scene), paths().draw(scene), 0.02, 0.12,
                      "closed, lamps: " + std::to_string(lamps));
  }
  drawn().set(1, "bounce");
  paths().set(1);
  const scene::Scene open = room(false, 2);
  const std::vector<glm::dvec3> alone = drawn().draw(open);
  expect_same_light(alone, paths().draw(open), 0.02, 0.12, "without a ceiling");
  drawn().set(1, "ao,bounce");
  EXPECT_EQ(drawn().draw_again(), alone) << "matte surfaces have no light that occlusion takes away twice";
  drawn().set(1, "bounce");
  EXPECT_LT(brightest(drawn().draw(room(true, 0))), 1e-3) << "no light enters a closed room";
}

// Rays that hit nothing leave the environment's light as it is, whatever the material.
TEST_F(DiffuseBounce, ConvexBodyMatchesEnvironmentOnly) {
  SceneBuilder builder;
  scene::Material cloth = matte({0.8f, 0.5f, 0.3f});
  cloth.roughness = 0.7f;
  cloth.sheen_color = glm::vec3(0.5f);
  cloth.sheen_roughness = 0.5f;
  cloth.clearcoat = 0.5f;
  cloth.clearcoat_roughness = 0.6f;
  builder.mesh_node("ball", builder.sphere(builder.material(cloth), 0.5f), glm::mat4(1));
  builder.camera_node("camera", {0, 0.5f, 2}, {0, 0, 0}, 0.6f);
  drawn().set(1, "bounce");
  const std::vector<glm::dvec3> seen = drawn().draw(builder.build());
  drawn().set(1, "off");
  const std::vector<glm::dvec3> plain = drawn().draw_again();
  EXPECT_GT(estimate(plain).mean, 0.05);
  for (size_t i = 0; i < plain.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(seen[i][c], plain[i][c], 2e-3 * plain[i][c] + 1e-4) << i << ", channel " << c;
  }
}

}  // namespace
}  // namespace fire3dv::test
