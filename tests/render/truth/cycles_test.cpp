// Path tracer and raster against images of Blender's Cycles: tests/render/goldens/cycles, made by
// tools/lab/truth/truth.py --cycles. The goldens hold linear radiance in halves.
#include <OpenEXR/ImfRgbaFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "examples/gallery/reference_scenes.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/textures/environment.h"
#include "tests/render/support/path_bench.h"
#include "tests/render/truth/ggx_further_bounces.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::test {
namespace {

const std::filesystem::path kFolder = FIRE3DV_CYCLES_GOLDENS;
constexpr double kTolerance = 2e-3;

struct Golden {
  VkExtent2D extent{};
  std::vector<glm::dvec3> pixels;
};

Golden read_golden(const std::string& name) {
  Imf::RgbaInputFile file((kFolder / (name + ".exr")).c_str());
  const Imath::Box2i window = file.dataWindow();
  Golden golden{{static_cast<uint32_t>(window.max.x + 1), static_cast<uint32_t>(window.max.y + 1)}, {}};
  std::vector<Imf::Rgba> texels(size_t{golden.extent.width} * golden.extent.height);
  file.setFrameBuffer(texels.data(), 1, golden.extent.width);
  file.readPixels(window.min.y, window.max.y);
  for (const Imf::Rgba& texel : texels) golden.pixels.emplace_back(texel.r, texel.g, texel.b);
  return golden;
}

scene::Scene load(const std::string& name) {
  const ScratchFolder folder;
  for (const gallery::SceneFile& file : gallery::make_reference_scenes()) {
    if (file.name != name + ".glb") continue;
    Result<scene::Scene> scene =
        scene::load_gltf(folder.write(file.name, std::as_bytes(std::span(file.bytes))));
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    // Of glass: the raster draws thin walls.
    EXPECT_TRUE(scene->warnings.empty() || name == "glass") << scene->warnings.front();
    return std::move(*scene);
  }
  ADD_FAILURE() << "no scene is called " << name;
  return {};
}

// Pixels whose neighbours are lit, too: neither silhouettes nor terminators.
std::vector<bool> interior(const Golden& golden, double least_share) {
  double brightest = 0;
  for (const glm::dvec3& pixel : golden.pixels) brightest = std::max(brightest, pixel.g);
  const auto width = static_cast<int>(golden.extent.width), height = static_cast<int>(golden.extent.height);
  std::vector<bool> result;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double least = brightest;
      for (int i = 0; i < 9; ++i) {
        const int nx = std::clamp(x + i % 3 - 1, 0, width - 1), ny = std::clamp(y + i / 3 - 1, 0, height - 1);
        least = std::min(least, golden.pixels[static_cast<size_t>(ny * width + nx)].g);
      }
      result.push_back(least > least_share * brightest);
    }
  }
  return result;
}

// Image in two halves, whose difference states the noise. It is drawn at twice the size: each pixel averages
// its area, as those of the golden, and each half has a diagonal of its quarters, so that gradients cancel.
struct Drawn {
  std::array<std::vector<glm::dvec3>, 2> halves;

  glm::dvec3 mean(size_t i) const { return (halves[0][i] + halves[1][i]) / 2.0; }
  glm::dvec3 noise(size_t i) const { return (halves[0][i] - halves[1][i]) / 2.0; }  // a sample of it
};

Drawn draw(const scene::Scene& scene, VkExtent2D extent, const settings::DrawSettings& settings) {
  const VkExtent2D fine{2 * extent.width, 2 * extent.height};
  const std::vector<glm::dvec3> quarters = linear_image(scene, fine, settings);
  Drawn drawn;
  for (std::vector<glm::dvec3>& half : drawn.halves)
    half.resize(size_t{extent.width} * extent.height, glm::dvec3(0));
  for (size_t i = 0; i < quarters.size(); ++i) {
    const size_t x = i % fine.width, y = i / fine.width;
    drawn.halves[(x + y) % 2][y / 2 * extent.width + x / 2] += quarters[i] / 2.0;
  }
  return drawn;
}

Drawn traced(const scene::Scene& scene, VkExtent2D extent, settings::DrawSettings settings) {
  settings.path->samples_per_pixel /= 4;
  return draw(scene, extent, settings);
}

// Without noise.
Drawn rasterised(const scene::Scene& scene, VkExtent2D extent) {
  settings::DrawSettings settings = path_settings(1, 0);
  settings.path.reset();
  settings.shadows.method = settings::ShadowMethod::ray;
  settings.shadows.hybrid = false;
  Drawn drawn = draw(scene, extent, settings);
  for (size_t i = 0; i < drawn.halves[0].size(); ++i) drawn.halves[0][i] = drawn.halves[1][i] = drawn.mean(i);
  return drawn;
}

// Relative to the mean of the golden.
struct Comparison {
  double difference = 0, noise = 0;  // mean absolute difference of a pixel, and the part that noise explains
  double bias = 0, bias_error = 0;   // difference of the means, and its standard error
  size_t pixels = 0;
};

Comparison compare(const Drawn& ours, const Golden& golden, const std::vector<bool>& where) {
  Comparison result;
  double sum = 0;
  for (size_t i = 0; i < golden.pixels.size(); ++i) {
    if (!where[i]) continue;
    ++result.pixels;
    const glm::dvec3 difference = ours.mean(i) - golden.pixels[i], noise = ours.noise(i);
    double of_pixel = 0;  // the channels of a pixel are not independent
    for (int c = 0; c < 3; ++c) {
      result.difference += std::abs(difference[c]);
      result.noise += std::abs(noise[c]);
      result.bias += difference[c];
      of_pixel += noise[c];
      sum += golden.pixels[i][c];
    }
    result.bias_error += of_pixel * of_pixel;
  }
  result.difference /= sum;
  result.noise /= sum;
  result.bias /= sum;
  result.bias_error = std::sqrt(result.bias_error) / sum;
  return result;
}

void expect_close(const Comparison& found, size_t least_pixels, const std::string& what) {
  testing::Test::RecordProperty(
      what, "pixels " + std::to_string(found.pixels) + ", difference " + std::to_string(found.difference) +
                ", noise " + std::to_string(found.noise) + "; means " + std::to_string(found.bias) + " +- " +
                std::to_string(found.bias_error));
  EXPECT_GE(found.pixels, least_pixels) << what;
  EXPECT_LT(found.difference, kTolerance + found.noise) << what;
  EXPECT_LT(std::abs(found.bias), kTolerance + 2 * found.bias_error) << what;
  EXPECT_LT(found.bias_error, kTolerance) << what << ": the estimate is too noisy to say anything";
}

class Cycles : public ValidationIsSilent {};

TEST_F(Cycles, MatteSurfacesUnderLamps) {
  const struct {
    const char* name;
    double least_share;  // of the brightest radiance, of compared pixels
    size_t least_pixels;
    uint32_t samples;
  } cases[] = {{"plane_point", 0, 3072, 64}, {"plane_sun", 0, 3072, 4}, {"ball_point", 0.05, 800, 128}};
  for (const auto& each : cases) {
    const Golden golden = read_golden(each.name);
    const scene::Scene scene = load(each.name);
    const std::vector<bool> where = interior(golden, each.least_share);
    const std::string name = each.name;
    expect_close(compare(traced(scene, golden.extent, path_settings(each.samples, 0)), golden, where),
                 each.least_pixels, name + ", path");
    expect_close(compare(rasterised(scene, golden.extent), golden, where), each.least_pixels,
                 name + ", raster");
  }
}

// Radiance of the bounces among facets after the first, which the golden does not have, at the middle of a
// pixel. 0 off the ball.
double further_bounces(const GgxFurtherBounces& facets, VkExtent2D extent, double x, double y) {
  const gallery::BallView view;
  const glm::dvec3 eye(view.eye_m[0], view.eye_m[1], view.eye_m[2]);
  const glm::dvec3 light(view.light_m[0], view.light_m[1], view.light_m[2]);
  const glm::dvec3 ahead = glm::normalize(-eye), right = glm::normalize(glm::cross(ahead, {0, 1, 0}));
  const double half = std::tan(static_cast<double>(view.vertical_fov_rad) / 2), height = extent.height;
  const glm::dvec3 ray = glm::normalize(ahead + half * (2 * x - extent.width) / height * right +
                                        half * (height - 2 * y) / height * glm::cross(right, ahead));
  const double along = -glm::dot(ray, eye), radius = static_cast<double>(view.radius_m);
  const double square = along * along - glm::dot(eye, eye) + radius * radius;
  if (square <= 0) return 0;
  const glm::dvec3 position = eye + (along - std::sqrt(square)) * ray, normal = position / radius;
  const double distance = glm::length(light - position);
  const double cos_light = glm::dot(normal, light - position) / distance;
  if (cos_light <= 0) return 0;
  return facets.brdf(-glm::dot(ray, normal), cos_light) * static_cast<double>(view.light_cd) * cos_light /
         (distance * distance);
}

// Cycles has one bounce among the facets. The further ones are taken off by their formula.
TEST_F(Cycles, AMetalBallUnderALamp) {
  const Golden golden = read_golden("metal_ball");
  const scene::Scene scene = load("metal_ball");
  const std::vector<bool> where = interior(golden, 0.02);
  const GgxFurtherBounces facets(static_cast<double>(gallery::BallView{}.metal_roughness));
  const auto one_bounce = [&](Drawn drawn) {
    for (size_t i = 0; i < golden.pixels.size(); ++i) {
      const double further =
          further_bounces(facets, golden.extent, static_cast<double>(i % golden.extent.width) + 0.5,
                          static_cast<double>(i / golden.extent.width) + 0.5);
      for (std::vector<glm::dvec3>& half : drawn.halves) half[i] -= glm::dvec3(further);
    }
    return drawn;
  };
  expect_close(compare(one_bounce(traced(scene, golden.extent, path_settings(128, 0))), golden, where), 350,
               "metal ball, path");
  expect_close(compare(one_bounce(rasterised(scene, golden.extent)), golden, where), 350,
               "metal ball, raster");
}

// All pixels, and the same in blocks, whose noise is less.
void expect_same_light(const std::string& name, const settings::DrawSettings& settings) {
  constexpr uint32_t kBlock = 4;
  const Golden golden = read_golden(name);
  const Drawn drawn = traced(load(name), golden.extent, settings);
  const auto blocks = [&](const std::vector<glm::dvec3>& pixels) {
    std::vector<glm::dvec3> sums(pixels.size() / (kBlock * kBlock), glm::dvec3(0));
    for (size_t i = 0; i < pixels.size(); ++i)
      sums[i / golden.extent.width / kBlock * (golden.extent.width / kBlock) +
           i % golden.extent.width / kBlock] += pixels[i];
    return sums;
  };
  const Drawn in_blocks{{blocks(drawn.halves[0]), blocks(drawn.halves[1])}};
  const Golden golden_blocks{{}, blocks(golden.pixels)};
  const std::vector<bool> all(golden_blocks.pixels.size(), true);
  expect_close(compare(in_blocks, golden_blocks, all), all.size(), name + ", blocks of 4 x 4");
}

TEST_F(Cycles, AClosedRoomWithAllBounces) {
  expect_same_light("room", path_settings(256, 64));
}

settings::DrawSettings environment_settings(uint32_t samples, uint32_t bounces) {
  Result<scene::EnvironmentImage> image = scene::load_environment(kFolder / "environment.exr");
  EXPECT_TRUE(image.ok()) << image.error().message;
  settings::DrawSettings settings = path_settings(samples, bounces);
  settings.environment = std::make_shared<scene::EnvironmentImage>(std::move(*image));
  settings.environment_intensity = 1;
  settings.background.show_environment = true;
  return settings;
}

TEST_F(Cycles, BallsInAnEnvironment) {
  expect_same_light("environment_balls", environment_settings(64, 8));
}

// Refraction, total reflection, and light that glass gathers.
TEST_F(Cycles, AGlassBall) {
  expect_same_light("glass", environment_settings(64, 16));
}

}  // namespace
}  // namespace fire3dv::test
