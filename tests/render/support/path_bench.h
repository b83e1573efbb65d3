// Path-traced images of test scenes, and estimates with their standard errors.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <memory>
#include <string>
#include <vector>

#include "renderer/scene/textures/environment.h"
#include "tests/render/support/render_bench.h"
#include "tests/render/support/scene_builder.h"

namespace fire3dv::test {

inline constexpr double kPi = 3.14159265358979;

inline std::shared_ptr<const scene::EnvironmentImage> constant_environment(glm::vec3 radiance) {
  return std::make_shared<scene::EnvironmentImage>(
      scene::make_environment(16, 8, [&](const glm::vec3&) { return radiance; }));
}

inline settings::DrawSettings path_settings(uint32_t samples_per_pixel, uint32_t bounces, uint32_t seed = 1) {
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.post.fxaa = false;
  settings.path =
      settings::PathSettings{.samples_per_pixel = samples_per_pixel, .bounces = bounces, .seed = seed};
  return settings;
}

// Pixels of the linear plane.
inline std::vector<glm::dvec3> linear_image(RenderBench& bench, const scene::Scene& scene,
                                            VkExtent2D extent) {
  const state::PoseState poses(scene);
  passes::ImageOutputs outputs;
  outputs.add(wire::kColorLinearF16);
  std::vector<glm::dvec3> pixels;
  const Taken taken = bench.take(poses, first_camera_view(scene, poses, extent), outputs);
  for (const uint64_t packed : taken.plane<uint64_t>(wire::kColorLinearF16))
    pixels.emplace_back(glm::unpackHalf4x16(packed));
  return pixels;
}

inline std::vector<glm::dvec3> linear_image(const scene::Scene& scene, VkExtent2D extent,
                                            const settings::DrawSettings& settings) {
  RenderBench bench(scene, extent, settings);
  return linear_image(bench, scene, extent);
}

// Mean of independent pixels that show one radiance, with its standard error.
struct Estimate {
  double mean = 0, error = 0, deviation = 0;  // deviation: of one pixel
};
inline Estimate estimate(const std::vector<glm::dvec3>& pixels, int channel = 1) {
  Estimate result;
  const auto n = static_cast<double>(pixels.size());
  for (const glm::dvec3& pixel : pixels) result.mean += pixel[channel] / n;
  for (const glm::dvec3& pixel : pixels)
    result.deviation += (pixel[channel] - result.mean) * (pixel[channel] - result.mean) / (n - 1);
  result.deviation = std::sqrt(result.deviation);
  result.error = result.deviation / std::sqrt(n);
  return result;
}

// Within 4 standard errors and half a percent.
inline void expect_equal(const Estimate& found, double truth, const std::string& what,
                         double relative = 0.005) {
  testing::Test::RecordProperty(what, std::to_string(found.mean) + " +- " + std::to_string(found.error));
  EXPECT_NEAR(found.mean, truth, 4 * found.error + relative * truth) << what << ", error " << found.error;
  EXPECT_LT(found.error, 0.0075 * truth) << what << ": the estimate is too noisy to say anything";
}

}  // namespace fire3dv::test
