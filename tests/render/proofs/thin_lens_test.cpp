// Render test of the path tracer's thin lens against the formula of the circle of confusion.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <vector>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class ThinLens : public ValidationIsSilent {};

constexpr VkExtent2D kSize{96, 64};
constexpr double kFocalLengthM = 0.05, kSensorM = 0.024;

passes::DrawSettings lens_settings(float f_number, float focus_distance_m, uint32_t samples_per_pixel = 256) {
  passes::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.post.fxaa = false;
  settings.path = passes::PathSettings{
      .samples_per_pixel = samples_per_pixel, .bounces = 0, .seed = 3, .lens = {f_number, focus_distance_m}};
  return settings;
}

// A small emissive ball on the axis of a camera whose lens has a focal length of 50 mm.
scene::Scene ball(float distance_m, float radius_m) {
  SceneBuilder builder;
  scene::Material material = matte({0, 0, 0});
  material.specular = 0;
  material.emissive = glm::vec3(50);
  builder.mesh_node("ball", builder.sphere(builder.material(material), radius_m), at({0, 0, -distance_m}));
  builder.camera_node("camera", {0, 0, 0}, {0, 0, -1},
                      2 * static_cast<float>(std::atan(kSensorM / 2 / kFocalLengthM)));
  return builder.build();
}

std::vector<double> radiance(const scene::Scene& scene, const passes::DrawSettings& settings) {
  RenderBench bench(scene, kSize, settings);
  const state::PoseState poses(scene);
  const Taken taken =
      bench.take(poses, first_camera_view(scene, poses, kSize), passes::ImageOutputs(wire::kColorLinearF16));
  std::vector<double> pixels;
  for (const uint64_t packed : taken.plane<uint64_t>(wire::kColorLinearF16))
    pixels.push_back(static_cast<double>(glm::unpackHalf4x16(packed).g));
  return pixels;
}

struct Spot {
  double x = 0, y = 0;     // centre, in pixels
  double diameter_px = 0;  // of the disc with the variance of the light
  double energy = 0;
};

// The variance of a disc along an axis is a sixteenth of the square of its diameter; that of a pixel is 1/12.
Spot spot_of(const std::vector<double>& pixels) {
  Spot spot;
  double xx = 0, yy = 0;
  for (uint32_t y = 0; y < kSize.height; ++y) {
    for (uint32_t x = 0; x < kSize.width; ++x) {
      const double light = pixels[size_t{y} * kSize.width + x];
      spot.energy += light;
      spot.x += light * x;
      spot.y += light * y;
      xx += light * x * x;
      yy += light * y * y;
    }
  }
  spot.x /= spot.energy;
  spot.y /= spot.energy;
  const double variance = (xx + yy) / spot.energy - spot.x * spot.x - spot.y * spot.y;
  spot.diameter_px = 4 * std::sqrt(std::max(variance / 2 - 1.0 / 12, 0.0));
  return spot;
}

TEST_F(ThinLens, ABallOffFocusIsAsLargeAsTheCircleOfConfusion) {
  constexpr float kFNumber = 0.2f, kFocusM = 2;
  for (const float distance_m : {1.3f, 1.6f, 3.0f, 8.0f}) {
    const float radius_m = 0.008f * distance_m;
    const Spot seen = spot_of(radiance(ball(distance_m, radius_m), lens_settings(kFNumber, kFocusM)));
    // The usual formula, on a sensor of 24 mm: aperture |d - m| / d f / (m - f). Its last factor is f / m
    // here, since the field of view is that of the focal length at any focus: 2.5 % less.
    const double aperture_m = kFocalLengthM / static_cast<double>(kFNumber);
    const double confusion_m = aperture_m * std::abs(static_cast<double>(distance_m - kFocusM)) /
                               static_cast<double>(distance_m) * kFocalLengthM / (kFocusM - kFocalLengthM);
    const double confusion_px = confusion_m / kSensorM * kSize.height;
    // Without blur the ball is this large.
    const double ball_px = 2 * 0.008 * kFocalLengthM / kSensorM * kSize.height;
    const double found_px = std::sqrt(seen.diameter_px * seen.diameter_px - ball_px * ball_px);
    RecordProperty("distance " + std::to_string(distance_m),
                   std::to_string(found_px) + " of " + std::to_string(confusion_px));
    EXPECT_NEAR(found_px, confusion_px, 0.05 * confusion_px) << distance_m;
    EXPECT_NEAR(found_px, confusion_px * (kFocusM - kFocalLengthM) / kFocusM, 0.02 * confusion_px)
        << distance_m << ": without focus breathing";
    EXPECT_NEAR(seen.x, (kSize.width - 1) / 2.0, 0.2);
    EXPECT_NEAR(seen.y, (kSize.height - 1) / 2.0, 0.2);
  }
}

TEST_F(ThinLens, ABallInFocusIsThatOfAPinhole) {
  const scene::Scene scene = ball(2, 0.1f);
  const std::vector<double> pinhole = radiance(scene, lens_settings(0, 0));
  const Spot sharp = spot_of(pinhole), focused = spot_of(radiance(scene, lens_settings(0.5f, 2)));
  EXPECT_NEAR(focused.diameter_px, sharp.diameter_px, 0.02 * sharp.diameter_px);
  EXPECT_NEAR(focused.energy, sharp.energy, 0.02 * sharp.energy);
  const Spot blurred = spot_of(radiance(scene, lens_settings(0.5f, 1)));
  EXPECT_GT(blurred.diameter_px, 1.1 * sharp.diameter_px);
  EXPECT_NEAR(blurred.energy, sharp.energy, 0.04 * sharp.energy) << "blur spreads light and loses none";
}

TEST_F(ThinLens, ANarrowLensIsAPinholeAndItsImageRepeats) {
  const scene::Scene scene = ball(3, 0.3f);
  const std::vector<double> narrow = radiance(scene, lens_settings(1000, 1, 16));
  EXPECT_EQ(narrow, radiance(scene, lens_settings(1000, 1, 16)));
  const std::vector<double> pinhole = radiance(scene, lens_settings(0, 0, 16));
  double difference = 0, sum = 0;
  for (size_t i = 0; i < narrow.size(); ++i) {
    difference += std::abs(narrow[i] - pinhole[i]);
    sum += pinhole[i];
  }
  EXPECT_LT(difference, 0.01 * sum);
  // The camera's own lens, unless the settings have one.
  scene::Scene with_lens = scene;
  with_lens.cameras[0].lens = {1000, 1};
  EXPECT_EQ(narrow, radiance(with_lens, lens_settings(0, 0, 16)));
  with_lens.cameras[0].lens = {0.2f, 1};
  EXPECT_EQ(narrow, radiance(with_lens, lens_settings(1000, 1, 16)));
  // A lens needs both numbers.
  EXPECT_EQ(pinhole, radiance(scene, lens_settings(0.2f, 0, 16)));
}

}  // namespace
}  // namespace fire3dv::test
