// Render test of the thin lens of paths and raster: the formula of the circle of confusion, the plane in
// focus, and the raster against paths.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <numeric>
#include <vector>

#include "tests/render/support/proof_bench.h"

namespace fire3dv::test {
namespace {

class ThinLens : public ValidationIsSilent {};

constexpr VkExtent2D kSize{96, 64};
constexpr double kFocalLengthM = 0.05, kSensorM = 0.024;

settings::DrawSettings lens_settings(float f_number, float focus_distance_m,
                                     uint32_t samples_per_pixel = 256) {
  settings::DrawSettings settings;
  settings.environment_intensity = 0;
  settings.background.color = glm::vec3(0);
  settings.post.fxaa = false;
  settings.path = settings::PathSettings{
      .samples_per_pixel = samples_per_pixel, .bounces = 0, .seed = 3, .lens = {f_number, focus_distance_m}};
  return settings;
}

settings::DrawSettings raster_settings(float f_number, float focus_distance_m, uint32_t samples = 4) {
  settings::DrawSettings settings = lens_settings(0, 0);
  settings.path.reset();
  settings.samples = samples;
  settings.post.lens = {f_number, focus_distance_m};
  return settings;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum;
}

double sum_of(const std::vector<double>& pixels) {
  return std::accumulate(pixels.begin(), pixels.end(), 0.0);
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

std::vector<double> radiance(RenderBench& bench, const scene::Scene& scene, VkExtent2D size) {
  const state::PoseState poses(scene);
  const Taken taken =
      bench.take(poses, first_camera_view(scene, poses, size), passes::ImageOutputs(wire::kColorLinearF16));
  std::vector<double> pixels;
  for (const uint64_t packed : taken.plane<uint64_t>(wire::kColorLinearF16))
    pixels.push_back(static_cast<double>(glm::unpackHalf4x16(packed).g));
  return pixels;
}

std::vector<double> radiance(const scene::Scene& scene, const settings::DrawSettings& settings,
                             VkExtent2D size = kSize) {
  RenderBench bench(scene, size, settings);
  return radiance(bench, scene, size);
}

struct Spot {
  double x = 0, y = 0;                 // centre, in pixels
  double diameter_px = 0;              // of the disc with the variance of the light
  double width_px = 0, height_px = 0;  // of the ellipse
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
  const double x_variance = xx / spot.energy - spot.x * spot.x,
               y_variance = yy / spot.energy - spot.y * spot.y;
  const auto diameter_px = [](double variance) { return 4 * std::sqrt(std::max(variance - 1.0 / 12, 0.0)); };
  spot.diameter_px = diameter_px((x_variance + y_variance) / 2);
  spot.width_px = diameter_px(x_variance);
  spot.height_px = diameter_px(y_variance);
  return spot;
}

TEST_F(ThinLens, DefocusMatchesCircleOfConfusion) {
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

// With fx and fy that differ, circles of confusion are ellipses of pixels.
TEST_F(ThinLens, AnisotropicPixelsHaveEllipses) {
  const scene::Scene scene = ball(4, 0.03f);
  const state::PoseState poses(scene);
  RenderBench bench(scene, kSize, raster_settings(0.1f, 2));
  passes::Intrinsics intrinsics = passes::intrinsics_of(scene.cameras[0], {kSize.width, kSize.height});
  const float fy_px = intrinsics.fy_px;
  const auto seen = [&] {
    const Taken taken = bench.take(poses, passes::make_view(intrinsics, glm::mat4(1)),
                                   passes::ImageOutputs(wire::kColorLinearF16));
    std::vector<double> pixels;
    for (const uint64_t packed : taken.plane<uint64_t>(wire::kColorLinearF16))
      pixels.push_back(static_cast<double>(glm::unpackHalf4x16(packed).g));
    return spot_of(pixels);
  };
  const Spot round = seen();
  EXPECT_GT(round.height_px, 14);
  EXPECT_NEAR(round.width_px, round.height_px, 0.02 * round.height_px);
  for (const float ratio : {0.5f, 2.0f}) {
    intrinsics.fx_px = ratio * fy_px;
    const Spot spot = seen();
    EXPECT_NEAR(spot.height_px, round.height_px, 0.04 * round.height_px) << ratio;
    EXPECT_NEAR(spot.width_px, ratio * round.width_px, 0.04 * ratio * round.width_px) << ratio;
    EXPECT_NEAR(spot.energy, ratio * round.energy, 0.04 * ratio * round.energy) << ratio;
  }
}

TEST_F(ThinLens, InFocusMatchesPinhole) {
  const scene::Scene scene = ball(2, 0.1f);
  const std::vector<double> pinhole = radiance(scene, lens_settings(0, 0));
  const Spot sharp = spot_of(pinhole), focused = spot_of(radiance(scene, lens_settings(0.5f, 2)));
  EXPECT_NEAR(focused.diameter_px, sharp.diameter_px, 0.02 * sharp.diameter_px);
  EXPECT_NEAR(focused.energy, sharp.energy, 0.02 * sharp.energy);
  const Spot blurred = spot_of(radiance(scene, lens_settings(0.5f, 1)));
  EXPECT_GT(blurred.diameter_px, 1.1 * sharp.diameter_px);
  EXPECT_NEAR(blurred.energy, sharp.energy, 0.04 * sharp.energy) << "blur spreads light and loses none";
}

TEST_F(ThinLens, NarrowLensMatchesPinhole) {
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

// One renderer for many scenes and lenses.
class RasterBench {
 public:
  RasterBench(const scene::Scene& first, VkExtent2D size, uint32_t samples)
      : bench_(first, size, raster_settings(0, 0, samples)), size_(size) {}
  // scene: outlives the bench.
  std::vector<double> radiance(const scene::Scene& scene, scene::ThinLens lens) {
    bench_.renderer().set_scene(scene);
    bench_.change_settings([&](settings::DrawSettings& s) { s.post.lens = lens; });
    return test::radiance(bench_, scene, size_);
  }

 private:
  RenderBench bench_;
  VkExtent2D size_;
};

// Blurred by the raster: 2 r f |1 / s - 1 / d| pixels.
TEST_F(ThinLens, RasterSpreadsDotOverCircle) {
  constexpr float kFNumber = 0.2f, kFocusM = 2;
  const float distances_m[] = {1.3f, 3.0f, 8.0f};
  std::vector<scene::Scene> scenes;
  for (const float distance_m : distances_m) scenes.push_back(ball(distance_m, 0.008f * distance_m));
  for (const uint32_t samples : {1u, 4u}) {
    RasterBench bench(scenes[0], kSize, samples);
    for (size_t i = 0; i < scenes.size(); ++i) {
      const Spot sharp = spot_of(bench.radiance(scenes[i], {}));
      const Spot seen = spot_of(bench.radiance(scenes[i], {kFNumber, kFocusM}));
      const double focal_length_px = kFocalLengthM / kSensorM * kSize.height;
      const double aperture_m = kFocalLengthM / static_cast<double>(kFNumber);
      const double truth_px =
          aperture_m * focal_length_px *
          std::abs(1 / static_cast<double>(kFocusM) - 1 / static_cast<double>(distances_m[i]));
      const double found_px =
          std::sqrt(seen.diameter_px * seen.diameter_px - sharp.diameter_px * sharp.diameter_px);
      const std::string what =
          "raster, distance " + std::to_string(distances_m[i]) + ", samples " + std::to_string(samples);
      RecordProperty(what, std::to_string(found_px) + " of " + std::to_string(truth_px) + ", energy " +
                               std::to_string(seen.energy / sharp.energy));
      EXPECT_NEAR(found_px, truth_px, 0.05 * truth_px) << what;
      EXPECT_NEAR(seen.energy, sharp.energy, 0.05 * sharp.energy) << what;
      EXPECT_NEAR(seen.x, sharp.x, 0.1) << what;
      EXPECT_NEAR(seen.y, sharp.y, 0.1) << what;
    }
  }
}

scene::Material glowing(SceneBuilder& builder, bool stripes) {
  scene::Material material = matte({0, 0, 0});
  material.specular = 0;
  material.emissive = stripes ? glm::vec3(1) : glm::vec3(0.3f, 0.9f, 0.5f);
  if (stripes)
    material.emissive_texture.texture = builder.texture(64, 64, false, [](float u, float v) {
      return glm::vec4(0.5f + 0.2f * std::sin(40 * u), 0.5f + 0.2f * std::sin(25 * u + 18 * v), 0.5f, 1);
    });
  return material;
}

// Seen from above: a small quad before a wall.
scene::Scene occluder_before_wall(float occluder_m, float wall_m) {
  SceneBuilder builder;
  builder.mesh_node("wall", builder.quad(builder.material(glowing(builder, true)), wall_m),
                    at({0, -wall_m, 0}));
  if (occluder_m > 0)
    builder.mesh_node("occluder", builder.quad(builder.material(glowing(builder, false)), 0.1f * occluder_m),
                      at({0.05f * occluder_m, -occluder_m, 0}));
  builder.camera_node("camera", {0, 0, 0}, {0, -1, 0},
                      2 * static_cast<float>(std::atan(kSensorM / 2 / kFocalLengthM)));
  return builder.build();
}

TEST_F(ThinLens, RasterOccluderMatchesPaths) {
  constexpr VkExtent2D kSmall{48, 32};
  struct Case {
    const char* name;
    float focus_m, f_number;
  };
  const scene::Scene scene = occluder_before_wall(2, 6);
  RasterBench bench(scene, kSmall, 4);
  const std::vector<double> pinhole = bench.radiance(scene, {});
  for (const Case& c : {Case{"focus on the wall", 6, 0.08f}, Case{"focus on the occluder", 2, 0.08f},
                        Case{"focus between", 3, 0.08f}, Case{"focus before both", 1.5f, 0.15f}}) {
    const std::vector<double> traced = radiance(scene, lens_settings(c.f_number, c.focus_m, 320), kSmall);
    const std::vector<double> blurred = bench.radiance(scene, {c.f_number, c.focus_m});
    const double error = difference(blurred, traced) / sum_of(traced);
    const double without = difference(pinhole, traced) / sum_of(traced);
    RecordProperty(c.name, std::to_string(error) + ", pinhole " + std::to_string(without));
    EXPECT_LT(error, 0.03) << c.name;
    EXPECT_GT(without, 2 * error) << c.name;
  }
}

TEST_F(ThinLens, RasterKeepsFocalPlane) {
  const scene::Scene wall = occluder_before_wall(0, 3);
  for (const uint32_t samples : {1u, 4u}) {
    RasterBench bench(wall, kSize, samples);
    const std::vector<double> sharp = bench.radiance(wall, {});
    EXPECT_EQ(bench.radiance(wall, {0.2f, 3}), sharp);
    EXPECT_EQ(bench.radiance(wall, {1000, 1}), sharp) << "a narrow lens blurs nothing, wherever its focus is";
    EXPECT_NE(bench.radiance(wall, {0.2f, 1}), sharp);
    EXPECT_EQ(bench.radiance(wall, {0.2f, 0}), sharp) << "a lens needs both numbers";
  }
}

TEST_F(ThinLens, RasterLensHasNoHistory) {
  scene::Scene scene = occluder_before_wall(2, 6);
  settings::DrawSettings settings = raster_settings(0.4f, 2);
  settings.post.bloom = 0.1f;
  settings.post.metered = true;
  const sinks::FrameImage image = RenderBench(scene, kSize, settings).draw_at_rest();
  const scene::Scene other = ball(1, 0.1f);
  RenderBench used(other, {40, 24}, settings);
  (void)used.draw_at_rest();
  used.renderer().set_scene(scene);
  used.set_size(kSize);
  const state::PoseState poses(scene);
  EXPECT_EQ(used.draw(poses, first_camera_view(scene, poses, kSize)).rgba8, image.rgba8);
  EXPECT_FALSE(used.renderer().can_take(passes::ImageOutputs(), 2)) << "several views share no HDR target";
  EXPECT_TRUE(used.renderer().can_take(passes::ImageOutputs(wire::kDepthF32), 2)) << "depths have no lens";
  used.change_settings([](settings::DrawSettings& s) { s.post.lens = {}; });
  const sinks::FrameImage pinhole = used.draw(poses, first_camera_view(scene, poses, kSize));
  EXPECT_NE(pinhole.rgba8, image.rgba8);

  scene.cameras[0].lens = {0.4f, 2};
  settings.post.lens = {};
  EXPECT_EQ(RenderBench(scene, kSize, settings).draw_at_rest().rgba8, image.rgba8);
  // A far plane changes depths only.
  scene.cameras[0].far_m = 20;
  const sinks::FrameImage with_far = RenderBench(scene, kSize, settings).draw_at_rest();
  int largest = 0;
  for (size_t i = 0; i < image.rgba8.size(); ++i)
    largest = std::max(largest, std::abs(image.rgba8[i] - with_far.rgba8[i]));
  EXPECT_LE(largest, 2);
  // The forward path has no depths for it.
  settings.raster = settings::RasterPath::forward;
  RenderBench forward(scene, kSize, settings);
  EXPECT_FALSE(forward.renderer().can_blur());
  (void)forward.draw_at_rest();
}

}  // namespace
}  // namespace fire3dv::test
